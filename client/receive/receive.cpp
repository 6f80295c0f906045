#include "receive.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <utility>

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

namespace {

void require_tagged_size(const ReceivedPicture& picture, const char* track) {
    const int width = picture_width(picture.info), height = picture_height(picture.info);
    const auto require = [&](const char* what, int found_width, int found_height) {
        if (found_width != width || found_height != height)
            throw WorkError(expected_found("frame " + std::to_string(picture.info.index) + ", " + track,
                                           what + (" of " + size_text(width, height)) + ", as it is tagged",
                                           size_text(found_width, found_height)));
    };
    require("a picture", picture.width(), picture.height());
    for (const auto& [what, plane] : {std::pair("depth", &picture.depth_m),
                                      {"mirrors", &picture.specular},
                                      {"depth of mirrored images", &picture.virtual_depth_m}})
        if (!plane->empty())
            require(what, plane->width(), plane->height());
}

}  // namespace

void require_tagged_sizes(const ReceivedFrame& frame) {
    require_tagged_size(frame.main, "main");
    for (const auto& [picture, track] : {std::pair(&frame.base, "base"),
                                         {&frame.right, "right eye"},
                                         {&frame.hidden, "hidden"},
                                         {&frame.small, "small"},
                                         {&frame.patches, "patches"}})
        if (*picture)
            require_tagged_size(**picture, track);
}

}  // namespace equistream
