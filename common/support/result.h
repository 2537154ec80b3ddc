#pragma once

#include <boost/system/result.hpp>

#include <string>
#include <utility>

/// Operating failures (input, disk, wire) are values: a code that decides the exit status and a sentence for the user.
namespace lumenfarm {

enum class ErrorCode {
    bad_input,    ///< the user's file, option or value is wrong: exit code 2
    failed,       ///< the machine or a peer failed (disk, network, memory): exit code 1
    no_space,     ///< the disk is full, and nothing was lost: exit code 1
    interrupted,  ///< the user stopped it; what was done is kept: exit code 3
};

struct Error {
    ErrorCode code = ErrorCode::failed;
    std::string sentence;  ///< one sentence that names file, element and value
};

inline Error bad_input(std::string sentence) { return {ErrorCode::bad_input, std::move(sentence)}; }
inline Error failed(std::string sentence) { return {ErrorCode::failed, std::move(sentence)}; }
inline Error no_space(std::string sentence) { return {ErrorCode::no_space, std::move(sentence)}; }
inline Error interrupted(std::string sentence) { return {ErrorCode::interrupted, std::move(sentence)}; }

/// Exit status of a program that ends with this error (design: 1 failed, 2 bad input, 3 interrupted).
int exit_code(const Error& error);

/// Called by boost::system::result when value() is asked of a failed result: a broken assumption, so it aborts.
[[noreturn]] void throw_exception_from_error(const Error& error, const boost::source_location& where);

template <class T>
using Result = boost::system::result<T, Error>;

}  // namespace lumenfarm
