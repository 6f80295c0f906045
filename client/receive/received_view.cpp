#include "received_view.h"

#include <equistream/bound.h>

namespace equistream {

namespace {

ImageView<const float> plane_or_nothing(const FloatImage& plane) {
    return plane.empty() ? ImageView<const float>{} : plane.view();
}

}  // namespace

double head_box_radius(const FrameInfo& info) {
    return head_box_radius(info.eye, info.head_radius_m, info.ipd_m);
}

SourceView source_view(const ReceivedPicture& picture, const FloatImage& depth_m) {
    return {.rgb = picture.rgb.empty() ? ImageView<const std::uint8_t>{} : picture.rgb.view(),
            .yuv = picture.yuv.planes,
            .camera = picture.info.camera,
            .pose = picture.info.camera_pose,
            .depth_m = plane_or_nothing(depth_m),
            .specular = plane_or_nothing(picture.specular),
            .virtual_depth_m = plane_or_nothing(picture.virtual_depth_m),
            .box_radius_m = head_box_radius(picture.info)};
}

}  // namespace equistream
