#include "source_lookup.h"

namespace equistream {

EquirectLookup::EquirectLookup(const EquirectCamera& camera)
    : width_(camera.width), height_(camera.height),
      middle_(float(0.5 * (camera.range.longitude_min + camera.range.longitude_max))),
      half_width_(0.5f * float(camera.width)), top_(float(camera.range.latitude_max)),
      columns_per_radian_(float(camera.width / camera.range.longitude_span())),
      rows_per_radian_(float(camera.height / camera.range.latitude_span())), closes_(camera.range.closes()),
      north_pole_(closes_ && camera.range.latitude_max > pi / 2 - 1e-9),
      south_pole_(closes_ && camera.range.latitude_min < -pi / 2 + 1e-9) {
    sin_longitude_.reserve(std::size_t(width_));
    cos_longitude_.reserve(std::size_t(width_));
    for (int x = 0; x < width_; ++x) {
        const double longitude = camera.range.longitude_min + (x + 0.5) * camera.range.longitude_span() / width_;
        sin_longitude_.push_back(float(std::sin(longitude)));
        cos_longitude_.push_back(float(std::cos(longitude)));
    }
    sin_latitude_.reserve(std::size_t(height_));
    cos_latitude_.reserve(std::size_t(height_));
    for (int y = 0; y < height_; ++y) {
        const double latitude = camera.range.latitude_max - (y + 0.5) * camera.range.latitude_span() / height_;
        sin_latitude_.push_back(float(std::sin(latitude)));
        cos_latitude_.push_back(float(std::cos(latitude)));
    }
}

void EquirectLookup::bring_inside(Taps& taps) const {
    for (int k = 0; k < 4; ++k) {
        int x = taps.x[k];
        int y = taps.y[k];
        if (y < 0) {
            y = 0;
            x += north_pole_ ? width_ / 2 : 0;
        } else if (y >= height_) {
            y = height_ - 1;
            x += south_pole_ ? width_ / 2 : 0;
        }
        taps.x[k] = closes_ ? (x + width_) % width_ : std::clamp(x, 0, width_ - 1);
        taps.y[k] = y;
    }
}

PerspectiveLookup::PerspectiveLookup(const PerspectiveCamera& camera)
    : width_(camera.width), height_(camera.height), focal_(float(camera.focal_px())),
      half_width_(0.5f * float(camera.width)), half_height_(0.5f * float(camera.height)) {}

}  // namespace equistream
