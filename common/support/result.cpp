#include "common/support/result.h"

#include "common/support/ensure.h"

#include <cstdio>
#include <cstdlib>

namespace lumenfarm {

int exit_code(const Error& error) {
    switch (error.code) {
        case ErrorCode::failed:
        case ErrorCode::no_space: return 1;
        case ErrorCode::bad_input: return 2;
        case ErrorCode::interrupted: return 3;
    }
    return 1;
}

void throw_exception_from_error(const Error& error, const boost::source_location& where) {
    std::fprintf(stderr, "lumenfarm: unchecked error at %s:%u: %s\n", where.file_name(),
                 static_cast<unsigned>(where.line()), error.sentence.c_str());
    std::abort();
}

void ensure(bool holds, const char* assumption, const char* file, int line) {
    if (holds) [[likely]]
        return;
    std::fprintf(stderr, "lumenfarm: broken assumption at %s:%d: %s\n", file, line, assumption);
    std::abort();
}

}  // namespace lumenfarm
