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

void require_size(const ReceivedPicture& picture, const char* track, const char* what, int width, int height) {
    const int tagged_width = picture_width(picture.info), tagged_height = picture_height(picture.info);
    if (width != tagged_width || height != tagged_height)
        throw WorkError(expected_found("frame " + std::to_string(picture.info.index) + ", " + track,
                                       what + (" of " + size_text(tagged_width, tagged_height)) + ", as it is tagged",
                                       size_text(width, height)));
}

void require_planes_of_tagged_size(const ReceivedPicture& picture, const char* track) {
    for (const auto& [what, plane] : {std::pair("depth", &picture.depth_m),
                                      {"mirrors", &picture.specular},
                                      {"depth of mirrored images", &picture.virtual_depth_m}})
        if (!plane->empty())
            require_size(picture, track, what, plane->width(), plane->height());
}

void require_tagged_size(const ReceivedPicture& picture, const char* track) {
    require_size(picture, track, "a picture", picture.width(), picture.height());
    require_planes_of_tagged_size(picture, track);
}

/// What is no atlas is looked up by its camera, whose size is not an atlas's.
void require_no_atlas(const ReceivedPicture& picture, const char* track) {
    if (picture.info.patches)
        throw WorkError(expected_found("frame " + std::to_string(picture.info.index) + ", " + track, "a whole picture",
                                       "a table of patches"));
}

}  // namespace

void require_tagged_sizes(const ReceivedFrame& frame) {
    require_no_atlas(frame.main, "main");
    require_tagged_size(frame.main, "main");
    for (const auto& [picture, track] : {std::pair(&frame.base, "base"),
                                         {&frame.right, "right eye"},
                                         {&frame.hidden, "hidden"},
                                         {&frame.small, "small"}})
        if (*picture) {
            require_no_atlas(**picture, track);
            require_tagged_size(**picture, track);
        }
    if (frame.patches)
        require_tagged_size(*frame.patches, "patches");
    for (const ReceivedPicture& view : frame.depth_views) {
        require_no_atlas(view, "a view's depth");
        require_planes_of_tagged_size(view, "a view's depth");
    }
}

}  // namespace equistream
