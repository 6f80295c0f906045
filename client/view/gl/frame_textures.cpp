#include "frame_textures.h"

#include <equistream/bound.h>

#include <utility>

namespace equistream::gl {

namespace {

double box_radius_m(const FrameInfo& info) {
    return head_box_radius(info.eye, info.lean_m, info.ipd_m);
}

ImageView<const std::uint8_t> rgb_of(const ReceivedPicture& picture) {
    return picture.yuv.empty() ? picture.rgb.view() : ImageView<const std::uint8_t>{};
}

YuvView yuv_of(const ReceivedPicture& picture) {
    return picture.yuv.empty() ? YuvView{} : picture.yuv.planes;
}

ImageView<const float> plane_or_nothing(const FloatImage& plane) {
    return plane.empty() ? ImageView<const float>{} : plane.view();
}

void upload_picture(const ReceivedPicture& picture, UploadedPicture& to) {
    to.view = source_view_of(picture);
    to.textures.upload(to.view);
}

}  // namespace

SourceView source_view_of(const ReceivedPicture& picture) {
    return {.rgb = rgb_of(picture),
            .yuv = yuv_of(picture),
            .camera = picture.info.camera,
            .pose = picture.info.camera_pose,
            .depth_m = plane_or_nothing(picture.depth_m),
            .specular = plane_or_nothing(picture.specular),
            .virtual_depth_m = plane_or_nothing(picture.virtual_depth_m),
            .box_radius_m = box_radius_m(picture.info)};
}

void FrameTextures::upload(std::shared_ptr<const ReceivedFrame> frame) {
    frame_ = std::move(frame);
    upload_picture(frame_->main, main_);
    has_small_ = frame_->small.has_value();
    if (has_small_)
        upload_picture(*frame_->small, small_);
    has_hidden_ = frame_->hidden.has_value();
    if (has_hidden_)
        upload_picture(*frame_->hidden, hidden_);
    patches_.reset();
    if (!frame_->patches || !frame_->patches->info.patches || frame_->patches->depth_m.empty() ||
        patch_atlas_problem(*frame_->patches->info.patches))
        return;
    const ReceivedPicture& patches = *frame_->patches;
    patches_ = PatchesView{.rgb = rgb_of(patches),
                           .yuv = yuv_of(patches),
                           .depth_m = patches.depth_m.view(),
                           .atlas = &*patches.info.patches,
                           .pose = patches.info.camera_pose,
                           .box_radius_m = box_radius_m(patches.info)};
    patch_textures_.upload(*patches_);
}

}  // namespace equistream::gl
