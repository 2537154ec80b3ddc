#pragma once

#include "common/support/ensure.h"
#include "common/support/limits.h"
#include "proto/blocks.h"
#include "proto/text.h"
#include "proto/wire_error.h"

#include <boost/mpl/bool.hpp>
#include <boost/serialization/serialization.hpp>

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

/// Two archives of our own that implement Boost.Serialization's Archive concept, so that messages keep the standard
/// serialize() members. Unlike the stock archives they are portable (little-endian, fixed widths), read no pointers,
/// and take no memory on the word of a peer: every count is checked against the bytes that are left, the field's limit
/// and a memory budget first.
///
/// What travels: bool (0 or 1), integers, enums (enum_last() names the last enumerator), finite float and double,
/// std::string, std::vector of values (count u32, then each), std::array, std::optional (bool, then the value), blocks
/// (count u32, then the elements as they lie in memory), and classes with serialize().
namespace lumenfarm::wire {

/// A text or vector with a limit of its own. Writing cuts a text that is too long (text.h); reading refuses it.
template <class T>
struct AtMost {
    T& value;
    std::size_t count_max;
};
template <class T>
AtMost<T> at_most(T& value, std::size_t count_max) {
    return {value, count_max};
}

/// A vector that travels as one block of memory.
template <class T>
struct Block {
    std::vector<T>& elements;
    std::size_t count_max;
};
template <class T>
requires travels_as_block<T> Block<T> block(std::vector<T>& elements, std::size_t count_max) {
    return {elements, count_max};
}

template <class T>
inline constexpr bool is_wrapper = false;
template <class T>
inline constexpr bool is_wrapper<AtMost<T>> = true;
template <class T>
inline constexpr bool is_wrapper<Block<T>> = true;

/// Passes fields to an archive in order; the body of a serialize() member.
template <class Archive, class... Fields>
void fields(Archive& ar, Fields&&... each) {
    (ar & ... & each);
}

template <class T>
concept Number = std::is_arithmetic_v<T> && !std::same_as<T, bool> && !std::same_as<T, long double>;

/// Appends to a byte vector. REQUIRES: vectors within their limits (checked by ensure).
class OutputArchive {
public:
    using is_saving = boost::mpl::true_;
    using is_loading = boost::mpl::false_;

    explicit OutputArchive(std::vector<std::byte>& out) : out_(out) {}

    template <class T>
    OutputArchive& operator<<(const T& value) {
        save(value);
        return *this;
    }
    template <class T>
    OutputArchive& operator&(const T& value) {
        save(value);
        return *this;
    }
    void save_binary(const void* address, std::size_t count) {
        const auto* bytes = static_cast<const std::byte*>(address);
        out_.insert(out_.end(), bytes, bytes + count);
    }
    template <class T>
    void register_type(const T* = nullptr) {}
    unsigned get_library_version() const { return 0; }

private:
    void save_count(std::size_t count) { save(static_cast<std::uint32_t>(count)); }

    template <Number T>
    void save(T value) {
        save_binary(&value, sizeof value);
    }
    template <std::same_as<bool> T>
    void save(T value) {
        save(static_cast<std::uint8_t>(value));
    }
    template <class T>
    requires std::is_enum_v<T>
    void save(T value) { save(static_cast<std::underlying_type_t<T>>(value)); }
    void save(const AtMost<std::string>& text) {
        const auto cut = presentable(text.value, text.count_max);
        save_count(cut.size());
        save_binary(cut.data(), cut.size());
    }
    template <class T>
    void save(const AtMost<std::vector<T>>& vector) {
        ensure(vector.value.size() <= vector.count_max, "a message's vector is within its limit");
        save_count(vector.value.size());
        for (const auto& element : vector.value) save(element);
    }
    template <class T>
    void save(const Block<T>& bulk) {
        ensure(bulk.elements.size() <= bulk.count_max, "a message's block is within its limit");
        save_count(bulk.elements.size());
        save_binary(bulk.elements.data(), bulk.elements.size() * sizeof(T));
    }
    template <class T, std::size_t n>
    void save(const std::array<T, n>& elements) {
        for (const auto& element : elements) save(element);
    }
    template <class T>
    void save(const std::optional<T>& value) {
        save(value.has_value());
        if (value) save(*value);
    }
    template <class T>
    requires(std::is_class_v<T> && !is_wrapper<T>) void save(const T& value) {
        boost::serialization::serialize_adl(*this, const_cast<T&>(value), 0);
    }

    std::vector<std::byte>& out_;
};

/// Reads foreign bytes. After the first refusal every read leaves its value alone, and refused() keeps the reason.
class InputArchive {
public:
    using is_saving = boost::mpl::false_;
    using is_loading = boost::mpl::true_;

    explicit InputArchive(std::span<const std::byte> bytes) : rest_(bytes) {}

    template <class T>
    InputArchive& operator>>(T&& value) {
        load(value);
        return *this;
    }
    template <class T>
    InputArchive& operator&(T&& value) {
        load(value);
        return *this;
    }
    void load_binary(void* address, std::size_t count) {
        if (!has(count)) return;
        if (count > 0) std::memcpy(address, rest_.data(), count);
        rest_ = rest_.subspan(count);
    }
    template <class T>
    void register_type(const T* = nullptr) {}
    unsigned get_library_version() const { return 0; }

    /// To be called after the message: refuses what is left over.
    void finish() {
        if (!rest_.empty()) refuse(WireError::trailing_bytes);
    }
    void refuse(WireError reason) {
        if (!refused_) refused_ = reason;
    }
    const std::optional<WireError>& refused() const { return refused_; }

private:
    bool has(std::size_t count) {
        if (!refused_ && count > rest_.size()) refused_ = WireError::truncated;
        return !refused_;
    }
    /// A count of elements that take at least `element_bytes` here and `memory_bytes` in memory, or 0 and refused.
    std::size_t load_count(std::size_t count_max, std::size_t element_bytes, std::size_t memory_bytes) {
        std::uint32_t count = 0;
        load(count);
        if (refused_) return 0;
        if (count > count_max)
            refuse(WireError::too_many);
        else if (count > rest_.size() / element_bytes)
            refuse(WireError::truncated);
        else if (count > memory_left_ / memory_bytes)
            refuse(WireError::out_of_memory);
        if (refused_) return 0;
        memory_left_ -= count * memory_bytes;
        return count;
    }

    template <Number T>
    void load(T& value) {
        T read{};
        load_binary(&read, sizeof read);
        if constexpr (std::is_floating_point_v<T>)
            if (!std::isfinite(read)) refuse(WireError::bad_value);
        if (!refused_) value = read;
    }
    template <std::same_as<bool> T>
    void load(T& value) {
        std::uint8_t read = 0;
        load(read);
        if (read > 1) refuse(WireError::bad_value);
        if (!refused_) value = read == 1;
    }
    template <class T>
    requires std::is_enum_v<T>
    void load(T& value) {
        static_assert(std::is_unsigned_v<std::underlying_type_t<T>>);
        std::underlying_type_t<T> read = 0;
        load(read);
        if (read > static_cast<std::underlying_type_t<T>>(enum_last(T{}))) refuse(WireError::bad_value);
        if (!refused_) value = static_cast<T>(read);
    }
    void load(const AtMost<std::string>& text) {
        const auto size = load_count(text.count_max, 1, 1);
        if (refused_) return;
        text.value.resize(size);
        load_binary(text.value.data(), size);
        if (!is_presentable(text.value)) refuse(WireError::bad_value);
    }
    template <class T>
    void load(const AtMost<std::vector<T>>& vector) {
        const auto count = load_count(vector.count_max, 1, sizeof(T));
        if (refused_) return;
        vector.value.clear();
        vector.value.reserve(count);
        for (std::size_t i = 0; i < count && !refused_; ++i) load(vector.value.emplace_back());
    }
    template <class T>
    void load(const Block<T>& bulk) {
        const auto count = load_count(bulk.count_max, sizeof(T), sizeof(T));
        if (refused_) return;
        bulk.elements.resize(count);
        load_binary(bulk.elements.data(), count * sizeof(T));
    }
    template <class T, std::size_t n>
    void load(std::array<T, n>& elements) {
        for (auto& element : elements) load(element);
    }
    template <class T>
    void load(std::optional<T>& value) {
        bool present = false;
        load(present);
        value.reset();
        if (refused_ || !present) return;
        load(value.emplace());
    }
    template <class T>
    requires(std::is_class_v<T> && !is_wrapper<T>) void load(T& value) {
        if (depth_ == limits::archive_depth_max) refuse(WireError::too_deep);
        if (refused_) return;
        ++depth_;
        boost::serialization::serialize_adl(*this, value, 0);
        --depth_;
    }

    std::span<const std::byte> rest_;
    std::size_t memory_left_ = limits::message_memory_bytes_max;
    unsigned depth_ = 0;
    std::optional<WireError> refused_;
};

}  // namespace lumenfarm::wire
