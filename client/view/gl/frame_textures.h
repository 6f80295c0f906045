#pragma once
/// One received frame on the GPU: the main picture and what came to fill its gaps.
#include <client/fill/gl/gap_resample.h>
#include <client/reflections/gl/specular.h>
#include <client/warp/gl/source_textures.h>

#include <client/receive/receive.h>

#include <array>
#include <memory>
#include <optional>

namespace equistream::gl {

/// Whether one of a frame's pictures is HDR: it needs a PqDisplay before it is uploaded.
bool has_hdr(const ReceivedFrame& frame);

/// A picture that was uploaded, and what it is of. `view`'s pixels are those of the frame.
struct UploadedPicture {
    SourceView view;
    SourceTextures textures;
};

/// A window that the gaze has left, with the sphere around it. Views are without pixels: these are on the GPU alone.
struct LeftTextures {
    UploadedPicture window, base;
    SpecularTextures specular;
    double shown_s = 0;

    const Camera& camera() const { return window.view.camera; }
    double time_s() const { return shown_s; }
};

class FrameTextures {
public:
    /// Uploads main, base, right eye, hidden layer, small view and patches and keeps the frame, so that views of it
    /// stay good. Storage of the frame before is used again. Throws WorkError where a picture has another size than it
    /// is tagged with; nothing has changed then.
    void upload(std::shared_ptr<const ReceivedFrame> frame);

    /// Gives the frame's window and base away and forgets the frame; takes storage for the next one's. The caller swaps
    /// the mirrors' textures.
    void trade_window(LeftTextures& left);

    /// SourceTextures', of all pictures; provided for before each upload.
    void read_in_place(const std::shared_ptr<PictureBuffers>& buffers);
    /// SourceTextures', of all pictures.
    void show_pq_by(const std::shared_ptr<const PqDisplay>& display);
    void show_again();

    const ReceivedFrame* frame() const { return frame_.get(); }  ///< null: nothing was uploaded
    const std::shared_ptr<const ReceivedFrame>& shared_frame() const { return frame_; }
    UploadedPicture& main() { return main_; }
    const UploadedPicture& main() const { return main_; }
    UploadedPicture* base() { return frame_->base ? &base_ : nullptr; }
    UploadedPicture* right() { return frame_->right ? &right_ : nullptr; }
    const UploadedPicture* right() const { return frame_->right ? &right_ : nullptr; }
    const UploadedPicture* hidden() const { return frame_->hidden ? &hidden_ : nullptr; }
    UploadedPicture* small() { return frame_->small ? &small_ : nullptr; }
    const PatchTextures* patches() const { return patches_ ? &patch_textures_ : nullptr; }
    const PatchesView& patches_view() const { return *patches_; }

private:
    std::array<SourceTextures*, 6> all_textures() {
        return {&main_.textures,   &base_.textures,  &right_.textures,
                &hidden_.textures, &small_.textures, &patch_textures_.atlas()};
    }

    std::shared_ptr<PictureBuffers> buffers_;  ///< null: there are none
    std::shared_ptr<const ReceivedFrame> frame_;
    UploadedPicture main_, base_, right_, hidden_, small_;
    PatchTextures patch_textures_;
    std::optional<PatchesView> patches_;
};

}  // namespace equistream::gl
