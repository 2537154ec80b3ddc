#include "worker/scene_cache.h"

#include "common/scene/scene_file.h"
#include "common/support/file.h"
#include "common/support/limits.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>

namespace lumenfarm::worker {

namespace fs = std::filesystem;

Result<std::shared_ptr<const std::vector<std::byte>>> SceneCache::load(const Digest& scene) const {
    const fs::path path = folder_ / scene.hex();
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return std::shared_ptr<const std::vector<std::byte>>();
    auto bytes = read_file(path, limits::scene_bytes_max);
    if (!bytes || scene_digest(*bytes) != scene) {
        fs::remove(path, ignored);
        return failed("'" + path.string() + "' is damaged; the scene is fetched again");
    }
    fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);
    return std::make_shared<const std::vector<std::byte>>(std::move(*bytes));
}

Result<std::vector<Digest>> SceneCache::keep(const Digest& scene, std::span<const std::byte> bytes) const {
    if (bytes.size() > bytes_max_) return bad_input("scene " + scene.hex() + " is larger than the whole cache");
    if (const auto made = make_folder(folder_); !made) return made.error();
    auto displaced = make_room(bytes.size());
    if (const auto written = write_file(folder_ / scene.hex(), bytes); !written) return written.error();
    return displaced;
}

std::vector<Digest> SceneCache::make_room(std::uint64_t bytes) const {
    struct File {
        Digest scene;
        fs::file_time_type used;
        std::uint64_t bytes;
    };
    remove_abandoned(folder_);
    std::vector<File> files;
    std::uint64_t sum = bytes;
    std::error_code error;
    for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
        const auto scene = Digest::from_hex(at->path().filename().string());
        if (!scene) continue;
        std::error_code ignored;
        const auto size = at->file_size(ignored);
        if (ignored) continue;
        files.push_back({*scene, at->last_write_time(ignored), size});
        sum += size;
    }
    std::sort(files.begin(), files.end(), [](const File& a, const File& b) { return a.used < b.used; });
    std::vector<Digest> displaced;
    for (std::size_t i = 0; i < files.size() && sum > bytes_max_; ++i) {
        fs::remove(folder_ / files[i].scene.hex(), error);
        sum -= files[i].bytes;
        displaced.push_back(files[i].scene);
    }
    return displaced;
}

fs::path default_cache_folder() {
    const char* home = std::getenv("XDG_CACHE_HOME");
    return home && *home ? fs::path(home) / "lumenfarm" : fs::path("/var/cache/lumenfarm");
}

}  // namespace lumenfarm::worker
