#pragma once
/// Buffers of the driver's that stay mapped: decoders write pictures into them, and passes read them there. Where the
/// driver maps nothing for good there are none, and nobody notices.
#include <client/gpu/objects.h>

#include <equistream/yuv.h>

#include <cstddef>
#include <memory>
#include <optional>

namespace equistream::gl {

/// Who hands out what, apart from the buffers themselves, for copies of what take() returned may outlive them.
struct PictureBlocks;

class PictureBuffers : public PictureMemory {
public:
    /// All of them together. Decoders hold some twenty pictures of a track, which are 11 MB each at 3840x1920.
    static constexpr std::size_t max_bytes = std::size_t{1} << 30;
    /// Made at once: whoever asks for long without a provide() is not given more for it.
    static constexpr std::size_t max_wanted = 8;
    /// What was not handed out while so many others were goes back to the driver.
    static constexpr int max_rounds_unused = 256;

    PictureBuffers();
    /// In the context of provide(). Nobody may write or read any more what was handed out.
    ~PictureBuffers() override;
    PictureBuffers(const PictureBuffers&) = delete;
    PictureBuffers& operator=(const PictureBuffers&) = delete;

    /// PictureMemory's. What was asked for in vain is there after the next provide().
    std::shared_ptr<std::uint8_t> take(std::size_t size) override;

    // In one context, which is current.
    /// Makes what was asked for in vain, and has what nobody holds handed out again once the GPU has read it.
    void provide();

    struct Place {
        GLuint buffer = 0;
        GLuint bytes = 0;  ///< a texture of all of the buffer's bytes (GL_TEXTURE_BUFFER, GL_R8UI)
        std::size_t offset = 0;
    };
    /// Where a sample that somebody holds lies; nothing for other memory.
    std::optional<Place> find(const void* sample) const;
    /// The buffer that a sample lies in is handed out again only when all commands until now are done.
    void was_read(const void* sample);

    /// That there are, handed out or not.
    std::size_t bytes() const;
    std::size_t count() const;

private:
    std::shared_ptr<PictureBlocks> blocks_;
    bool may_map_ = true;
};

}  // namespace equistream::gl
