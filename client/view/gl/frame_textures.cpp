#include "frame_textures.h"

#include <equistream/bound.h>
#include <equistream/error.h>
#include <equistream/formatted.h>

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

/// Shaders fetch by what tags say.
void require_tagged_size(const ReceivedPicture& picture, const char* track) {
    const int width = picture_width(picture.info), height = picture_height(picture.info);
    const auto is_whole = [&](const FloatImage& plane) {
        return plane.empty() || (plane.width() == width && plane.height() == height);
    };
    if (picture.width() != width || picture.height() != height || !is_whole(picture.depth_m) ||
        !is_whole(picture.specular) || !is_whole(picture.virtual_depth_m))
        throw WorkError(expected_found(formatted("frame %lld, %s", static_cast<long long>(picture.info.index), track),
                                       formatted("a picture of %dx%d, as it is tagged", width, height),
                                       formatted("%dx%d", picture.width(), picture.height())));
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
    require_tagged_size(frame->main, "main");
    if (frame->hidden)
        require_tagged_size(*frame->hidden, "hidden");
    if (frame->patches)
        require_tagged_size(*frame->patches, "patches");
    frame_ = std::move(frame);
    upload_picture(frame_->main, main_);
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
