#include "proto/archive.h"

#include "proto/shared_types.h"

#include <gtest/gtest.h>

#include <limits>
#include <memory>

namespace lumenfarm::wire {
namespace {

enum class Colour : std::uint8_t { red, green, blue };
constexpr Colour enum_last(Colour) { return Colour::blue; }

/// One field of each kind.
struct Everything {
    bool flag = false;
    std::uint8_t small = 0;
    std::int64_t large = 0;
    float ratio = 0;
    double length = 0;
    Colour colour = Colour::red;
    std::string name;
    std::array<std::int16_t, 3> triple{};
    std::optional<std::uint32_t> maybe, absent;
    std::vector<ParticleRange> ranges;
    std::vector<HitRecord> hits;
    Digest digest;
    bool operator==(const Everything&) const = default;

    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, flag, small, large, ratio, length, colour, at_most(name, 8), triple, maybe, absent,
               at_most(ranges, 4), block(hits, 4), digest);
    }
};

Everything sample() {
    Everything value;
    value.flag = true;
    value.small = 200;
    value.large = std::numeric_limits<std::int64_t>::min();
    value.ratio = -0.25f;
    value.length = 1e300;
    value.colour = Colour::blue;
    value.name = "lux";
    value.triple = {-1, 2, -3};
    value.maybe = 9;
    value.ranges = {{1, 2, 3}, {4, 5, 6}};
    value.hits = {{1, 2, 3, 4, 5, 6, 7}};
    value.digest.bytes.fill(0xab);
    return value;
}

template <class T>
std::vector<std::byte> bytes_of(const T& value) {
    std::vector<std::byte> bytes;
    OutputArchive archive(bytes);
    archive << value;
    return bytes;
}

/// Not inlined: g++ 12 takes the optional for uninitialized otherwise.
[[gnu::noinline]] std::optional<WireError> outcome(const InputArchive& archive) { return archive.refused(); }

template <class T>
std::optional<WireError> read(std::span<const std::byte> bytes, T& value) {
    InputArchive archive(bytes);
    archive >> value;
    archive.finish();
    return outcome(archive);
}

template <class T>
std::optional<WireError> refusal(std::span<const std::byte> bytes) {
    T value{};
    return read(bytes, value);
}

TEST(Archive, EveryKindOfFieldComesBack) {
    const auto written = sample();
    Everything value;
    EXPECT_EQ(read(bytes_of(written), value), std::nullopt);
    EXPECT_EQ(value, written);
}

struct Two {
    std::uint8_t a = 1;
    std::uint32_t b = 0x05040302;
    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, a, b);
    }
};

TEST(Archive, FieldsAreLittleEndianAndUnpadded) {
    const auto bytes = bytes_of(Two());
    ASSERT_EQ(bytes.size(), 5u);
    for (unsigned i = 0; i < 5; ++i) EXPECT_EQ(std::to_integer<unsigned>(bytes[i]), i + 1);
}

TEST(Archive, EveryTruncationIsRefused) {
    const auto bytes = bytes_of(sample());
    for (std::size_t size = 0; size < bytes.size(); ++size)
        EXPECT_EQ(refusal<Everything>(std::span(bytes).first(size)), WireError::truncated) << size;
}

TEST(Archive, BytesLeftOverAreRefused) {
    auto bytes = bytes_of(sample());
    bytes.push_back({});
    EXPECT_EQ(refusal<Everything>(bytes), WireError::trailing_bytes);
}

TEST(Archive, ValuesThatAreNoneAreRefused) {
    EXPECT_EQ(refusal<bool>(bytes_of(std::uint8_t{2})), WireError::bad_value);
    EXPECT_EQ(refusal<Colour>(bytes_of(std::uint8_t{3})), WireError::bad_value);
    EXPECT_EQ(refusal<Colour>(bytes_of(std::uint8_t{2})), std::nullopt);
    EXPECT_EQ(refusal<double>(bytes_of(std::numeric_limits<double>::quiet_NaN())), WireError::bad_value);
    EXPECT_EQ(refusal<float>(bytes_of(std::numeric_limits<float>::infinity())), WireError::bad_value);
    EXPECT_EQ(refusal<std::optional<bool>>(bytes_of(std::uint16_t{0x0201})), WireError::bad_value);
}

struct Bulk {
    std::vector<HitRecord> hits;
    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, block(hits, limits::hits_per_message_max));
    }
};

TEST(Archive, CountIsCheckedBeforeMemoryIsTaken) {
    Bulk bulk;
    EXPECT_EQ(read(bytes_of(std::uint32_t{limits::hits_per_message_max}), bulk), WireError::truncated);
    EXPECT_EQ(bulk.hits.capacity(), 0u);
    EXPECT_EQ(read(bytes_of(std::uint32_t{0xffffffff}), bulk), WireError::too_many);
    EXPECT_EQ(bulk.hits.capacity(), 0u);
}

/// 256 KiB in memory for a byte on the wire.
struct Wasteful {
    std::uint8_t used = 0;
    std::array<char, 256 << 10> unused{};
    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, used);
    }
};
struct Wasteland {
    std::vector<Wasteful> all;
    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, at_most(all, 1'000));
    }
};

TEST(Archive, MemoryBudgetHoldsWhereTheBytesAreThere) {
    auto bytes = bytes_of(std::uint32_t{100});
    bytes.resize(bytes.size() + 100);
    Wasteland wasteland;
    EXPECT_EQ(read(bytes, wasteland), WireError::out_of_memory);
    EXPECT_EQ(wasteland.all.capacity(), 0u);
}

struct Nested {
    std::vector<Nested> inside;
    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, at_most(inside, 1));
    }
};

TEST(Archive, DepthIsBounded) {
    const auto nested = [](unsigned levels) {
        std::vector<std::byte> bytes;
        for (unsigned i = 0; i + 1 < levels; ++i) {
            const auto one = bytes_of(std::uint32_t{1});
            bytes.insert(bytes.end(), one.begin(), one.end());
        }
        bytes.resize(bytes.size() + 4);
        return bytes;
    };
    EXPECT_EQ(refusal<Nested>(nested(limits::archive_depth_max)), std::nullopt);
    EXPECT_EQ(refusal<Nested>(nested(limits::archive_depth_max + 1)), WireError::too_deep);
    EXPECT_EQ(refusal<Nested>(nested(100'000)), WireError::too_deep);
}

struct Text {
    std::string text;
    template <class Archive>
    void serialize(Archive& ar, unsigned) {
        fields(ar, at_most(text, 5));
    }
};

TEST(Archive, TextIsCutBetweenCharactersWhenWritten) {
    Text written, value;
    written.text = "lum\xc3\xa9n";  // 7 bytes; the accented letter is the 4th and 5th
    EXPECT_EQ(read(bytes_of(written), value), std::nullopt);
    EXPECT_EQ(value.text, "lum\xc3\xa9");
    written.text = "lume\xc3\xa9";
    EXPECT_EQ(read(bytes_of(written), value), std::nullopt);
    EXPECT_EQ(value.text, "lume");
}

TEST(Archive, ControlCharactersDoNotTravel) {
    Text written, value;
    written.text = "a\x1b[2J";
    EXPECT_EQ(read(bytes_of(written), value), std::nullopt);
    EXPECT_EQ(value.text, "a [2J");
    auto foreign = bytes_of(written);
    foreign[4] = std::byte{0x1b};
    EXPECT_EQ(read(foreign, value), WireError::bad_value);
}

TEST(Archive, TextOverItsLimitIsRefused) {
    auto bytes = bytes_of(std::uint32_t{6});
    bytes.resize(10, std::byte{'a'});
    EXPECT_EQ(refusal<Text>(bytes), WireError::too_many);
}

TEST(Archive, NothingIsReadAfterARefusal) {
    const auto bytes = bytes_of(std::uint16_t{0x0702});
    InputArchive archive(bytes);
    bool flag = false;
    std::uint8_t next = 1;
    archive >> flag >> next;
    EXPECT_EQ(outcome(archive), WireError::bad_value);
    EXPECT_EQ(next, 1);
}

}  // namespace
}  // namespace lumenfarm::wire
