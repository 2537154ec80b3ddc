#include "tests/fuzz/fuzzer.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

/// Without arguments: runs the target over its corpus, and over mutations of it from a fixed seed. With a folder:
/// writes the corpus there, one file an input, for libFuzzer to start from.
namespace {

using Bytes = std::vector<std::byte>;
using Random = std::mt19937_64;

constexpr std::size_t inputs_total = 40'000;  ///< about: a second or two
constexpr std::size_t bytes_total = 64u << 20;

void run(const Bytes& input) {
    // A copy of the exact size, so that a sanitizer sees the first byte that is read too far.
    const Bytes exact(input.begin(), input.end());
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(exact.data()), exact.size());
}

/// Changes that parsers trip over: cut short, bits flipped, extreme lengths, a piece of another input.
Bytes mutated(Bytes input, const Bytes& other, Random& random) {
    for (auto changes = 1 + random() % 3; changes > 0 && !input.empty(); --changes) {
        const auto at = random() % input.size();
        switch (random() % 5) {
            case 0: input.resize(at); break;
            case 1: input[at] ^= std::byte{1} << (random() % 8); break;
            case 2: input[at] = static_cast<std::byte>(random()); break;
            case 3:
                for (std::size_t i = at; i < std::min(at + 4, input.size()); ++i) input[i] = std::byte{0xff};
                break;
            default:
                for (std::size_t i = 0; at + i < input.size() && i < other.size() && i < 16; ++i)
                    input[at + i] = other[i];
        }
    }
    return input;
}

void run_mutations(const std::vector<Bytes>& seeds) {
    Random random(20'260'101);
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < inputs_total && bytes < bytes_total; ++i) {
        const auto& seed = seeds[i % seeds.size()];
        bytes += seed.size() + 1;
        run(mutated(seed, seeds[random() % seeds.size()], random));
    }
}

int write_corpus(const std::vector<Bytes>& seeds, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
        std::ofstream file(folder / ("seed-" + std::to_string(i)), std::ios::binary);
        file.write(reinterpret_cast<const char*>(seeds[i].data()), static_cast<std::streamsize>(seeds[i].size()));
        if (!file) return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
    const auto seeds = lumenfarm::test::corpus_seeds();
    if (seeds.empty()) {
        std::fputs("the target has no corpus\n", stderr);
        return EXIT_FAILURE;
    }
    if (argc > 1) return write_corpus(seeds, argv[1]);
    run({});
    for (const auto& seed : seeds) run(seed);
    run_mutations(seeds);
    return EXIT_SUCCESS;
}
