#include "proto/wire_error.h"

#include "common/support/ensure.h"

#include <cstdlib>

namespace lumenfarm::wire {

std::string_view name_of(WireError error) {
    switch (error) {
        case WireError::bad_magic: return "bad_magic";
        case WireError::unsupported_version: return "unsupported_version";
        case WireError::unknown_type: return "unknown_type";
        case WireError::unexpected_type: return "unexpected_type";
        case WireError::unknown_flags: return "unknown_flags";
        case WireError::payload_too_large: return "payload_too_large";
        case WireError::bad_lengths: return "bad_lengths";
        case WireError::bad_checksum: return "bad_checksum";
        case WireError::bad_compression: return "bad_compression";
        case WireError::truncated: return "truncated";
        case WireError::too_many: return "too_many";
        case WireError::too_deep: return "too_deep";
        case WireError::out_of_memory: return "out_of_memory";
        case WireError::bad_value: return "bad_value";
        case WireError::trailing_bytes: return "trailing_bytes";
    }
    return "unknown";
}

void throw_exception_from_error(const WireError& error, const boost::source_location& where) {
    ensure(false, name_of(error).data(), where.file_name(), static_cast<int>(where.line()));
    std::abort();
}

}  // namespace lumenfarm::wire
