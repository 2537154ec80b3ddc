#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace lumenfarm {

/// How often each reason of an enumeration has come up. REQUIRES of the enumeration, beside it: name_of(reason), and
/// enum_last(reason), its last enumerator.
template <class Reason>
class Tally {
public:
    static constexpr std::size_t reasons = static_cast<std::size_t>(enum_last(Reason{})) + 1;

    void count(Reason reason, std::uint64_t times = 1) { counts_[static_cast<std::size_t>(reason)] += times; }
    std::uint64_t of(Reason reason) const { return counts_[static_cast<std::size_t>(reason)]; }

    /// Calls visit(reason, count) for every reason, also those that have not come up.
    template <class Visit>
    void each(Visit visit) const {
        for (std::size_t i = 0; i < reasons; ++i) visit(static_cast<Reason>(i), counts_[i]);
    }

    /// "silent 2, by_peer 3": what has come up; empty when nothing has.
    std::string text() const {
        std::string text;
        each([&](Reason reason, std::uint64_t count) {
            if (count == 0) return;
            text += (text.empty() ? "" : ", ") + std::string(name_of(reason)) + " " + std::to_string(count);
        });
        return text;
    }

private:
    std::array<std::uint64_t, reasons> counts_{};
};

}  // namespace lumenfarm
