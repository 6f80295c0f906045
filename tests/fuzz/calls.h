#pragma once
/// What calls of a C ABI are given: numbers that people get wrong, and what must come of every call.
#include "target.h"

#include <equistream/abi_types.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

namespace equistream::fuzz {

inline double wrong_number(Choices& choices) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    constexpr std::array numbers = {0.0,  -0.0,  1.0,   -1.0, 0.5,  1e-320,
                                    1e-9, 3.0,   1e6,   -1e6, 1e9,  1.1e9,
                                    1e19, -1e19, 1e300, inf,  -inf, std::numeric_limits<double>::quiet_NaN()};
    return choices.one_of(numbers);
}

inline int wrong_count(Choices& choices) {
    constexpr std::array counts = {0, 1, 2, 3, 16, 32, 63, 64, -1, -64, 16385, 1 << 20, 1 << 30, INT32_MAX, INT32_MIN};
    return choices.one_of(counts);
}

/// A value that the enumeration may not have: callers in C set any.
template <typename Enumeration>
void set_any(Choices& choices, Enumeration& value) {
    const int any = choices.below(4) == 0 ? wrong_count(choices) : choices.below(5);
    static_assert(sizeof value == sizeof any);
    std::memcpy(&value, &any, sizeof any);
}

/// A turn, or something that is none.
inline void spoil(Choices& choices, es_pose& pose) {
    double* const numbers = choices.yes() ? pose.position_m : pose.orientation_wxyz;
    numbers[choices.below(3)] = choices.yes() ? wrong_number(choices) : choices.take<std::int8_t>() / 64.0;
}

inline void check_status(es_status status, const es_error& error) {
    require(status >= ES_OK && status <= ES_DONE, "a status is one of the four");
    const std::size_t length = strnlen(error.text, sizeof error.text);
    require(length < sizeof error.text, "an error's text ends");
    require((status == ES_OK || status == ES_DONE) || length > 0, "a call that fails says why");
    for (std::size_t i = 0; i < length; ++i)
        require(static_cast<unsigned char>(error.text[i]) >= 0x20, "an error is one line without control characters");
}

/// A call that takes an es_error last.
template <typename Call>
es_status checked(const Call& call) {
    es_error error{};
    const es_status status = call(&error);
    check_status(status, error);
    return status;
}

}  // namespace equistream::fuzz
