#include "receive.h"

#include <equistream/bound.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <utility>

namespace equistream {

constexpr double shortest_interval_s = 1.0 / 30;

bool PoseSender::send(const ViewerPose& pose) {
    const std::lock_guard lock(mutex_);
    const bool is_known = last_ && last_->position_m == pose.head.position_m &&
                          last_->orientation == pose.head.orientation && last_view_ == view_;
    if (!connection_ || is_known || (last_ && seconds_since(last_at_) < shortest_interval_s))
        return false;
    if (!connection_(encode_viewer_pose({pose.time_s, pose.head, view_})))
        return false;
    last_ = pose.head;
    last_view_ = view_;
    last_at_ = Clock::now();
    return true;
}

void PoseSender::look_through(const PerspectiveCamera& view) {
    const std::lock_guard lock(mutex_);
    view_ = extent_of(view);
}

void PoseSender::use(Connection connection) {
    const std::lock_guard lock(mutex_);
    connection_ = std::move(connection);
    last_.reset();
}

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
