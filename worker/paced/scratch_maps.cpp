#include "worker/paced/scratch_maps.h"

#include <algorithm>
#include <thread>
#include <utility>

namespace lumenfarm::worker {

ScratchMaps::ScratchMaps(const LightMap& empty) {
    for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i)
        free_.push_back(std::make_unique<LightMap>(empty));
}

void ScratchMaps::with_map(const std::function<void(LightMap&)>& use) {
    std::unique_lock lock(mutex_);
    given_back_.wait(lock, [this] { return !free_.empty(); });
    std::unique_ptr<LightMap> map = std::move(free_.back());
    free_.pop_back();
    lock.unlock();
    use(*map);
    lock.lock();
    free_.push_back(std::move(map));
    given_back_.notify_one();
}

}  // namespace lumenfarm::worker
