#pragma once

#include "common/support/result.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace lumenfarm {

/// A SHA-256 digest: the name of a scene, a chunk or a result.
struct Digest {
    std::array<std::uint8_t, 32> bytes{};

    auto operator<=>(const Digest&) const = default;
    std::string hex() const;  ///< 64 lower-case hexadecimal digits
    /// REQUIRES nothing; bad_input when `text` is not 64 hexadecimal digits.
    static Result<Digest> from_hex(const std::string& text);
};

Digest sha256(std::span<const std::byte> bytes);

/// SHA-256 over a sequence of blocks.
class Sha256 {
public:
    Sha256();
    void update(std::span<const std::byte> bytes);
    Digest finish();  ///< REQUIRES: called once

private:
    struct Free {
        void operator()(void* context) const;
    };
    std::unique_ptr<void, Free> context_;
};

}  // namespace lumenfarm
