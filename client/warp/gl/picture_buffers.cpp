#include "picture_buffers.h"

#include <equistream/error.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

namespace equistream::gl {

namespace {

/// Read by decoders too: without the flag to read, a driver may map memory that is slow to.
constexpr GLbitfield mapping = GL_MAP_READ_BIT | GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;

struct Block {
    Buffer buffer;
    Texture bytes_texture;
    std::uint8_t* bytes = nullptr;
    std::size_t size = 0;
    GLsync read_until = nullptr;  ///< when the GPU will have read it; null: it has
    bool is_held = false;
    std::int64_t taken_in_round = 0;

    bool contains(const void* sample) const {
        const auto at = reinterpret_cast<std::uintptr_t>(sample), first = reinterpret_cast<std::uintptr_t>(bytes);
        return at >= first && at < first + size;
    }
};

/// Of a buffer that a shader reads byte by byte. Limits may be more than an int has room for.
std::size_t max_block() {
    GLint64 texels = 0;
    glGetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    return std::size_t(std::min<std::int64_t>(texels, max_storage_bytes()));
}

/// Null where the driver has no memory, or does not map it for good.
std::unique_ptr<Block> make_block(std::size_t size) {
    auto block = std::make_unique<Block>();
    block->size = size;
    try {
        block->buffer = make_buffer(size, mapping);
    } catch (const WorkError&) {
        return nullptr;
    }
    block->bytes =
        static_cast<std::uint8_t*>(glMapNamedBufferRange(block->buffer.name(), 0, GLsizeiptr(size), mapping));
    if (block->bytes == nullptr)
        return nullptr;
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture);
    block->bytes_texture = Texture(texture);
    glTextureBuffer(texture, GL_R8UI, block->buffer.name());
    return block;
}

bool is_signalled(GLsync fence) {
    const GLenum state = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
    return state == GL_ALREADY_SIGNALED || state == GL_CONDITION_SATISFIED;
}

void forget(Block& block) {
    if (block.read_until != nullptr)
        glDeleteSync(std::exchange(block.read_until, nullptr));
}

}  // namespace

struct PictureBlocks {
    std::mutex mutex;
    std::vector<std::unique_ptr<Block>> blocks;
    std::vector<std::size_t> wanted;  ///< in vain, since the last provide()
    std::int64_t round = 0;           ///< of take()
    bool is_closed = false;

    /// Null: there is none.
    Block* find(const void* sample) {
        const std::lock_guard lock(mutex);
        const auto found =
            std::ranges::find_if(blocks, [&](const auto& block) { return block->is_held && block->contains(sample); });
        return found == blocks.end() ? nullptr : found->get();
    }
    /// What was asked for in vain; blocks that nobody needs any more are `unused` from now on.
    std::vector<std::size_t> sort_out(std::vector<std::unique_ptr<Block>>& unused) {
        const std::lock_guard lock(mutex);
        for (const auto& block : blocks)
            if (block->read_until != nullptr && is_signalled(block->read_until))
                forget(*block);
        const auto first_unused = std::partition(blocks.begin(), blocks.end(), [&](const auto& block) {
            return block->is_held || block->read_until != nullptr ||
                   round - block->taken_in_round <= PictureBuffers::max_rounds_unused;
        });
        std::move(first_unused, blocks.end(), std::back_inserter(unused));
        blocks.erase(first_unused, blocks.end());
        return std::exchange(wanted, {});
    }
};

PictureBuffers::PictureBuffers() : blocks_(std::make_shared<PictureBlocks>()) {}

PictureBuffers::~PictureBuffers() {
    const std::lock_guard lock(blocks_->mutex);
    blocks_->is_closed = true;
    for (const auto& block : blocks_->blocks) {
        forget(*block);
        block->bytes_texture = {};
        block->buffer = {};
    }
}

std::shared_ptr<std::uint8_t> PictureBuffers::take(std::size_t size) {
    const std::lock_guard lock(blocks_->mutex);
    if (blocks_->is_closed)
        return nullptr;
    ++blocks_->round;
    // What went round last goes round next, so that what is not needed shows.
    Block* newest = nullptr;
    for (const auto& block : blocks_->blocks)
        if (block->size == size && !block->is_held && block->read_until == nullptr &&
            (newest == nullptr || block->taken_in_round > newest->taken_in_round))
            newest = block.get();
    if (newest == nullptr) {
        if (blocks_->wanted.size() < max_wanted)
            blocks_->wanted.push_back(size);
        return nullptr;
    }
    newest->is_held = true;
    newest->taken_in_round = blocks_->round;
    return {newest->bytes, [blocks = blocks_, newest](std::uint8_t*) {
                const std::lock_guard releasing(blocks->mutex);
                newest->is_held = false;
            }};
}

/// Decoders do not wait while the driver makes buffers, or frees them.
void PictureBuffers::provide() {
    std::vector<std::unique_ptr<Block>> unused;
    const std::vector<std::size_t> wanted = blocks_->sort_out(unused);
    unused.clear();
    for (const std::size_t size : wanted) {
        if (!may_map_ || size > max_block() || bytes() + size > max_bytes)
            continue;
        std::unique_ptr<Block> block = make_block(size);
        may_map_ = block != nullptr;
        if (!block)
            continue;
        const std::lock_guard lock(blocks_->mutex);
        block->taken_in_round = blocks_->round;
        blocks_->blocks.push_back(std::move(block));
    }
}

std::optional<PictureBuffers::Place> PictureBuffers::find(const void* sample) const {
    const Block* const block = blocks_->find(sample);
    if (block == nullptr)
        return std::nullopt;
    return Place{block->buffer.name(), block->bytes_texture.name(),
                 std::size_t(static_cast<const std::uint8_t*>(sample) - block->bytes)};
}

void PictureBuffers::was_read(const void* sample) {
    Block* const block = blocks_->find(sample);
    if (block == nullptr)
        return;
    const std::lock_guard lock(blocks_->mutex);
    forget(*block);
    block->read_until = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
}

std::size_t PictureBuffers::bytes() const {
    const std::lock_guard lock(blocks_->mutex);
    std::size_t sum = 0;
    for (const auto& block : blocks_->blocks)
        sum += block->size;
    return sum;
}

std::size_t PictureBuffers::count() const {
    const std::lock_guard lock(blocks_->mutex);
    return blocks_->blocks.size();
}

}  // namespace equistream::gl
