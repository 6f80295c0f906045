#pragma once
/// Between a variant's arrays, which may live on a device, and ours.
#include <host-adapters/mitsuba3/plugins/parameters.h>

#include "embedded_scene.h"

#include <drjit/dynamic.h>
#include <mitsuba/core/transform.h>
#include <mitsuba/core/vector.h>

#include <cmath>

namespace equistream::mitsuba_host {

template <typename Float>
struct VariantArrays {
    static constexpr bool is_jit = drjit::is_jit_v<Float>;
    using UInt32 = drjit::uint32_array_t<Float>;
    using Floats = mitsuba::DynamicBuffer<Float>;
    using Integers = mitsuba::DynamicBuffer<UInt32>;
    using Transform = mitsuba::AffineTransform<mitsuba::Point<Float, 4>>;
    using UvTransform = mitsuba::AffineTransform<mitsuba::Point<Float, 3>>;
    using ScalarUvTransform = mitsuba::AffineTransform<mitsuba::Point<float, 3>>;

    template <typename Storage>
    static std::vector<drjit::scalar_t<Storage>> to_host(const Storage& storage) {
        if constexpr (is_jit) {
            std::vector<drjit::scalar_t<Storage>> host(storage.size());
            if (!host.empty())
                drjit::store(host.data(), drjit::detach(storage));
            return host;
        } else {
            return {storage.data(), storage.data() + storage.size()};
        }
    }

    static Floats floats(const std::vector<float>& values) { return drjit::load<Floats>(values.data(), values.size()); }
    static Integers integers(const std::vector<std::uint32_t>& values) {
        return drjit::load<Integers>(values.data(), values.size());
    }

    /// Opaque: a literal would be compiled into the kernel, anew for every frame.
    static Transform transform(const Matrix34& rows) {
        drjit::Matrix<Float, 4> matrix = drjit::identity<drjit::Matrix<Float, 4>>();
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 4; ++column)
                matrix.entry(row, column) = Float(static_cast<float>(rows[row * 4 + column]));
        Transform result(matrix);
        drjit::make_opaque(result);
        return result;
    }

    static Matrix34 rows_of(const Transform& transform) {
        Matrix34 rows{};
        for (std::size_t row = 0; row < 3; ++row)
            for (std::size_t column = 0; column < 4; ++column)
                rows[row * 4 + column] = scalar(transform.matrix.entry(row, column));
        return rows;
    }

    /// How often a texture repeats along u and v over [0, 1].
    static std::array<double, 2> repeats_of(const Parameters& texture) {
        if (const auto* uv = texture.template find<ScalarUvTransform>("to_uv"))
            return column_lengths(*uv, [](float value) { return value; });
        if (const auto* uv = texture.template find<UvTransform>("to_uv"))
            return column_lengths(*uv, scalar);
        return {1, 1};
    }

    /// `value(uv)` at the centres of width x height cells of [0, 1]^2, row by row.
    template <typename Value>
    static std::vector<float> evaluated(int width, int height, Value value) {
        if constexpr (is_jit) {
            const UInt32 cell =
                drjit::arange<UInt32>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
            const UInt32 row = cell / static_cast<std::uint32_t>(width);
            const UInt32 column = cell - row * static_cast<std::uint32_t>(width);
            const std::pair uv{(Float(column) + 0.5f) / static_cast<float>(width),
                               (Float(row) + 0.5f) / static_cast<float>(height)};
            Float result = value(uv);
            if (result.size() == 1)
                result = result + drjit::zeros<Float>(cell.size());
            return to_host(result);
        } else {
            std::vector<float> values;
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    values.push_back(value(std::pair{(static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                                                     (static_cast<float>(y) + 0.5f) / static_cast<float>(height)}));
            return values;
        }
    }

private:
    template <typename UvMap, typename Scalar>
    static std::array<double, 2> column_lengths(const UvMap& uv, Scalar value) {
        const auto length = [&](std::size_t column) {
            return std::max<double>(1,
                                    std::hypot(value(uv.matrix.entry(0, column)), value(uv.matrix.entry(1, column))));
        };
        return {length(0), length(1)};
    }

    static double scalar(const Float& value) {
        if constexpr (is_jit)
            return drjit::slice(drjit::detach(value), 0);
        else
            return value;
    }
};

}  // namespace equistream::mitsuba_host
