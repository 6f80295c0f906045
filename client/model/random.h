#pragma once
/// Random numbers that are the same with every standard library.
#include <equistream/conventions.h>

#include <glm/glm.hpp>

#include <cmath>
#include <random>

namespace equistream {

class Random {
public:
    explicit Random(std::uint64_t seed) : bits_(seed) {}

    double unit() { return double(bits_() >> 11) * 0x1p-53; }  ///< in [0, 1)
    glm::dvec3 on_sphere() {
        const double z = 2 * unit() - 1, angle = 2 * pi * unit(), r = std::sqrt(1 - z * z);
        return {r * std::cos(angle), r * std::sin(angle), z};
    }
    glm::dvec3 in_ball() { return on_sphere() * std::cbrt(unit()); }

private:
    std::mt19937_64 bits_;
};

}  // namespace equistream
