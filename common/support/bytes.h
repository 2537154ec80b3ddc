#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

/// Little-endian bytes of our own files. Values are copied as they lie in memory, which every supported machine
/// (x86-64) stores little-endian.
namespace lumenfarm {

static_assert(std::endian::native == std::endian::little);

template <class T>
concept PlainBlock = std::is_trivially_copyable_v<T>;

class ByteWriter {
public:
    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    void value(T v) {
        const auto* begin = reinterpret_cast<const std::byte*>(&v);
        bytes_.insert(bytes_.end(), begin, begin + sizeof v);
    }
    void text(const std::string& text) {
        value(static_cast<std::uint32_t>(text.size()));
        const auto* begin = reinterpret_cast<const std::byte*>(text.data());
        bytes_.insert(bytes_.end(), begin, begin + text.size());
    }
    /// Count (u64), then the elements as one block. REQUIRES: T has no padding.
    template <PlainBlock T>
    void block(std::span<const T> elements) {
        value(static_cast<std::uint64_t>(elements.size()));
        raw(std::as_bytes(elements));
    }
    /// As they are, with no count before them.
    void raw(std::span<const std::byte> bytes) { bytes_.insert(bytes_.end(), bytes.begin(), bytes.end()); }
    /// In place of what was written there. REQUIRES: it lies within bytes().
    template <class T>
    requires std::is_arithmetic_v<T>
    void replace(std::size_t position, T v) { std::memcpy(bytes_.data() + position, &v, sizeof v); }
    const std::vector<std::byte>& bytes() const { return bytes_; }
    std::vector<std::byte> take() { return std::move(bytes_); }

private:
    std::vector<std::byte> bytes_;
};

/// Reads foreign bytes. After the first value that is not there, good() is false and every read gives zeros; memory
/// taken never exceeds the bytes that remain.
class ByteReader {
public:
    explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T> T value() {
        T v{};
        if (!good_ || rest_.size() < sizeof v) {
            good_ = false;
            return v;
        }
        std::memcpy(&v, rest_.data(), sizeof v);
        rest_ = rest_.subspan(sizeof v);
        return v;
    }
    std::string text(std::size_t bytes_max) {
        const auto size = value<std::uint32_t>();
        if (!good_ || size > bytes_max || size > rest_.size()) {
            good_ = false;
            return {};
        }
        std::string text(reinterpret_cast<const char*>(rest_.data()), size);
        rest_ = rest_.subspan(size);
        return text;
    }
    template <PlainBlock T>
    std::vector<T> block(std::uint64_t count_max) {
        const auto count = value<std::uint64_t>();
        if (!good_ || count > count_max || count > rest_.size() / sizeof(T)) {
            good_ = false;
            return {};
        }
        std::vector<T> elements(count);
        if (count > 0) std::memcpy(elements.data(), rest_.data(), count * sizeof(T));
        rest_ = rest_.subspan(count * sizeof(T));
        return elements;
    }
    bool good() const { return good_; }
    std::size_t remaining() const { return rest_.size(); }
    void fail() { good_ = false; }

private:
    std::span<const std::byte> rest_;
    bool good_ = true;
};

}  // namespace lumenfarm
