#include "ray_directions.h"

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

/// Squares reach up to this many pixels beyond the picture.
constexpr int margin = packet_side - 1;

}  // namespace

RayDirections::RayDirections(const Camera& camera, const glm::dquat& orientation)
    : equirect_(std::holds_alternative<EquirectCamera>(camera)) {
    const int width = width_of(camera), height = height_of(camera);
    for (auto [vectors, length] : {std::pair{&column_, width}, {&row_, height}})
        for (std::vector<float>* list : {&vectors->x, &vectors->y, &vectors->z})
            list->resize(std::size_t(length + margin));
    row_cos_.resize(std::size_t(height + margin), 1.0f);
    const glm::dmat3 axes = glm::mat3_cast(orientation);
    const auto* sphere = std::get_if<EquirectCamera>(&camera);
    for (int i = 0; i < width + margin; ++i) {
        const double u = std::min(i, width - 1) + 0.5;
        if (sphere != nullptr) {
            const double longitude = sphere->range.longitude_min + u * sphere->range.longitude_span() / width;
            const auto d = direction_from_longitude_latitude(longitude, 0.0);
            set(column_, std::size_t(i), axes * glm::dvec3(d.x, d.y, d.z));
        } else {
            const auto& view = std::get<PerspectiveCamera>(camera);
            set(column_, std::size_t(i), axes * glm::dvec3((u - 0.5 * width) / view.focal_px(), 0, -1));
        }
    }
    for (int i = 0; i < height + margin; ++i) {
        const double v = std::min(i, height - 1) + 0.5;
        if (sphere != nullptr) {
            const double latitude = sphere->range.latitude_max - v * sphere->range.latitude_span() / height;
            set(row_, std::size_t(i), axes * glm::dvec3(0, std::sin(latitude), 0));
            row_cos_[std::size_t(i)] = float(std::cos(latitude));
        } else {
            const auto& view = std::get<PerspectiveCamera>(camera);
            set(row_, std::size_t(i), axes * glm::dvec3(0, (0.5 * height - v) / view.focal_px(), 0));
        }
    }
}

void RayDirections::set(Vectors& vectors, std::size_t i, const glm::dvec3& v) const {
    vectors.x[i] = float(v.x);
    vectors.y[i] = float(v.y);
    vectors.z[i] = float(v.z);
}

void RayDirections::write(int lane, int x, int y, DirectionPacket& out) const {
    const auto column = std::size_t(x), row = std::size_t(y);
    const float c = row_cos_[row];
    out.x[lane] = c * column_.x[column] + row_.x[row];
    out.y[lane] = c * column_.y[column] + row_.y[row];
    out.z[lane] = c * column_.z[column] + row_.z[row];
}

namespace {

void normalise(DirectionPacket& out) {
    for (int lane = 0; lane < packet_size; ++lane) {
        const float scale =
            1.0f / std::sqrt(out.x[lane] * out.x[lane] + out.y[lane] * out.y[lane] + out.z[lane] * out.z[lane]);
        out.x[lane] *= scale;
        out.y[lane] *= scale;
        out.z[lane] *= scale;
    }
}

}  // namespace

void RayDirections::square(int x, int y, DirectionPacket& out) const {
    for (int j = 0; j < packet_side; ++j)
        for (int i = 0; i < packet_side; ++i)
            write(j * packet_side + i, x + i, y + j, out);
    if (!equirect_)
        normalise(out);
}

}  // namespace equistream
