#include "cli/products/json_text.h"

#include <boost/json.hpp>

#include <array>
#include <charconv>
#include <cmath>

namespace lumenfarm {
namespace {

std::string number_text(double number) {
    if (!std::isfinite(number)) return "null";
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr;
    return {digits.data(), end};
}

void append(std::string& out, const boost::json::value& value, const std::string& indent) {
    const std::string deeper = indent + "  ";
    const char* separator = "\n";
    if (const auto* object = value.if_object(); object && !object->empty()) {
        out += '{';
        for (const auto& [key, member] : *object) {
            out += separator + deeper + boost::json::serialize(boost::json::value(key)) + ": ";
            append(out, member, deeper);
            separator = ",\n";
        }
        out += "\n" + indent + "}";
    } else if (const auto* array = value.if_array(); array && !array->empty()) {
        out += '[';
        for (const auto& element : *array) {
            out += separator + deeper;
            append(out, element, deeper);
            separator = ",\n";
        }
        out += "\n" + indent + "]";
    } else if (const auto* number = value.if_double()) {
        out += number_text(*number);
    } else {
        out += boost::json::serialize(value);
    }
}

}  // namespace

std::string json_text(const boost::json::value& value) {
    std::string text;
    append(text, value, "");
    return text + "\n";
}

}  // namespace lumenfarm
