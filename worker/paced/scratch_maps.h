#pragma once

#include "common/solution/solution.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace lumenfarm::worker {

/// Maps in which results are put together, as many as there are cores: more threads would wait for those anyway, and
/// thousands of workers would have thousands of maps.
class ScratchMaps {
public:
    /// `empty`: a map that holds nothing.
    explicit ScratchMaps(const LightMap& empty);
    /// Calls `use` with a map that holds nothing, and has to hold nothing again. Waits for one.
    void with_map(const std::function<void(LightMap&)>& use);

private:
    std::mutex mutex_;
    std::condition_variable given_back_;
    std::vector<std::unique_ptr<LightMap>> free_;
};

}  // namespace lumenfarm::worker
