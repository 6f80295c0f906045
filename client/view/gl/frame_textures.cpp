#include "frame_textures.h"

#include <utility>

namespace equistream::gl {

namespace {

void upload_picture(const ReceivedPicture& picture, UploadedPicture& to) {
    to.view = source_view(picture, picture.depth_m);
    to.textures.upload(to.view, picture.pq.planes);
}

void give(UploadedPicture& picture, UploadedPicture& to) {
    picture.textures.swap_pictures(to.textures);
    const SourceView& view = picture.view;
    to.view = {.camera = view.camera, .pose = view.pose, .box_radius_m = view.box_radius_m};
}

}  // namespace

bool has_hdr(const ReceivedFrame& frame) {
    const auto is_hdr = [](const std::optional<ReceivedPicture>& picture) { return picture && !picture->pq.empty(); };
    return !frame.main.pq.empty() || is_hdr(frame.base) || is_hdr(frame.right) || is_hdr(frame.hidden) ||
           is_hdr(frame.small) || is_hdr(frame.patches);
}

void FrameTextures::read_in_place(const std::shared_ptr<PictureBuffers>& buffers) {
    buffers_ = buffers;
    for (SourceTextures* textures : all_textures())
        textures->read_in_place(buffers);
}

void FrameTextures::show_pq_by(const std::shared_ptr<const PqDisplay>& display) {
    for (SourceTextures* textures : all_textures())
        textures->show_pq_by(display);
}

void FrameTextures::show_again() {
    for (SourceTextures* textures : all_textures())
        textures->show_again();
}

void FrameTextures::trade_window(LeftTextures& left) {
    give(main_, left.window);
    give(base_, left.base);
    left.shown_s = frame_->main.info.time_s;
    frame_.reset();
}

void FrameTextures::upload(std::shared_ptr<const ReceivedFrame> frame) {
    require_tagged_sizes(*frame);  // shaders fetch by what tags say
    if (buffers_)
        buffers_->provide();
    frame_ = std::move(frame);
    upload_picture(frame_->main, main_);
    for (const auto& [picture, to] : {std::pair(&frame_->base, &base_),
                                      {&frame_->right, &right_},
                                      {&frame_->hidden, &hidden_},
                                      {&frame_->small, &small_}})
        if (*picture)
            upload_picture(**picture, *to);
    patches_.reset();
    if (!frame_->patches || !frame_->patches->info.patches || frame_->patches->depth_m.empty() ||
        patch_atlas_problem(*frame_->patches->info.patches))
        return;
    const ReceivedPicture& patches = *frame_->patches;
    const SourceView pixels = source_view(patches, patches.depth_m);
    patches_ = PatchesView{.rgb = pixels.rgb,
                           .yuv = pixels.yuv,
                           .depth_m = pixels.depth_m,
                           .atlas = &*patches.info.patches,
                           .pose = pixels.pose,
                           .box_radius_m = pixels.box_radius_m};
    patch_textures_.upload(*patches_, patches.pq.planes);
}

}  // namespace equistream::gl
