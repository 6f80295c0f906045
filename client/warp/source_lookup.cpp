#include "source_lookup.h"

namespace equistream {

EquirectLookup::EquirectLookup(const EquirectCamera& camera) : grid_(source_grid(camera)) {
    sin_longitude_.reserve(std::size_t(camera.width));
    cos_longitude_.reserve(std::size_t(camera.width));
    for (int x = 0; x < camera.width; ++x) {
        const double longitude = camera.range.longitude_min + (x + 0.5) * camera.range.longitude_span() / camera.width;
        sin_longitude_.push_back(float(std::sin(longitude)));
        cos_longitude_.push_back(float(std::cos(longitude)));
    }
    sin_latitude_.reserve(std::size_t(camera.height));
    cos_latitude_.reserve(std::size_t(camera.height));
    for (int y = 0; y < camera.height; ++y) {
        const double latitude = camera.range.latitude_max - (y + 0.5) * camera.range.latitude_span() / camera.height;
        sin_latitude_.push_back(float(std::sin(latitude)));
        cos_latitude_.push_back(float(std::cos(latitude)));
    }
}

}  // namespace equistream
