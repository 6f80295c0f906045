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

}  // namespace

class PictureBlocks : public std::enable_shared_from_this<PictureBlocks> {
public:
    std::shared_ptr<std::uint8_t> take(std::size_t size) {
        const std::lock_guard lock(mutex_);
        if (is_closed_)
            return nullptr;
        ++round_;
        // What went round last goes round next, so that what is not needed shows.
        Block* newest = nullptr;
        for (const auto& block : blocks_)
            if (block->size == size && !block->is_held && block->read_until == nullptr &&
                (newest == nullptr || block->taken_in_round > newest->taken_in_round))
                newest = block.get();
        if (newest == nullptr) {
            if (wanted_.size() < PictureBuffers::max_wanted)
                wanted_.push_back(size);
            return nullptr;
        }
        newest->is_held = true;
        newest->taken_in_round = round_;
        return {newest->bytes, [blocks = shared_from_this(), newest](std::uint8_t*) { blocks->release(*newest); }};
    }

    /// Decoders do not wait while the driver makes buffers, or frees them.
    void provide(bool& may_map) {
        std::vector<std::unique_ptr<Block>> unused;
        const std::vector<std::size_t> wanted = sort_out(unused);
        unused.clear();
        for (const std::size_t size : wanted) {
            if (!may_map || size > max_block() || total_bytes() + size > PictureBuffers::max_bytes)
                continue;
            std::unique_ptr<Block> block = make_block(size);
            may_map = block != nullptr;
            if (block)
                add(std::move(block));
        }
    }

    /// Null: there is none.
    Block* find(const void* sample) const {
        const std::lock_guard lock(mutex_);
        const auto found =
            std::ranges::find_if(blocks_, [&](const auto& block) { return block->is_held && block->contains(sample); });
        return found == blocks_.end() ? nullptr : found->get();
    }

    void was_read(const void* sample) {
        Block* const block = find(sample);
        if (block == nullptr)
            return;
        const std::lock_guard lock(mutex_);
        forget(*block);
        block->read_until = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    }

    void close() {
        const std::lock_guard lock(mutex_);
        is_closed_ = true;
        for (const auto& block : blocks_) {
            forget(*block);
            block->bytes_texture = {};
            block->buffer = {};
        }
    }

    std::size_t total_bytes() const {
        const std::lock_guard lock(mutex_);
        std::size_t sum = 0;
        for (const auto& block : blocks_)
            sum += block->size;
        return sum;
    }
    std::size_t count() const {
        const std::lock_guard lock(mutex_);
        return blocks_.size();
    }

private:
    /// What was asked for in vain; blocks that nobody needs any more are `unused` from now on.
    std::vector<std::size_t> sort_out(std::vector<std::unique_ptr<Block>>& unused) {
        const std::lock_guard lock(mutex_);
        for (const auto& block : blocks_)
            if (block->read_until != nullptr && is_signalled(block->read_until))
                forget(*block);
        const auto first_unused = std::ranges::partition(blocks_, [&](const auto& block) {
            return block->is_held || block->read_until != nullptr ||
                   round_ - block->taken_in_round <= PictureBuffers::max_rounds_unused;
        });
        std::ranges::move(first_unused, std::back_inserter(unused));
        blocks_.erase(first_unused.begin(), first_unused.end());
        return std::exchange(wanted_, {});
    }
    void add(std::unique_ptr<Block> block) {
        const std::lock_guard lock(mutex_);
        block->taken_in_round = round_;
        blocks_.push_back(std::move(block));
    }
    void release(Block& block) {
        const std::lock_guard lock(mutex_);
        block.is_held = false;
    }
    static bool is_signalled(GLsync fence) {
        const GLenum state = glClientWaitSync(fence, GL_SYNC_FLUSH_COMMANDS_BIT, 0);
        return state == GL_ALREADY_SIGNALED || state == GL_CONDITION_SATISFIED;
    }
    static void forget(Block& block) {
        if (block.read_until != nullptr)
            glDeleteSync(std::exchange(block.read_until, nullptr));
    }

    mutable std::mutex mutex_;
    std::vector<std::unique_ptr<Block>> blocks_;
    std::vector<std::size_t> wanted_;  ///< in vain, since the last provide()
    std::int64_t round_ = 0;           ///< of take()
    bool is_closed_ = false;
};

PictureBuffers::PictureBuffers() : blocks_(std::make_shared<PictureBlocks>()) {}

PictureBuffers::~PictureBuffers() {
    blocks_->close();
}

std::shared_ptr<std::uint8_t> PictureBuffers::take(std::size_t bytes) {
    return blocks_->take(bytes);
}

void PictureBuffers::provide() {
    blocks_->provide(may_map_);
}

std::optional<PictureBuffers::Place> PictureBuffers::find(const void* sample) const {
    const Block* const block = blocks_->find(sample);
    if (block == nullptr)
        return std::nullopt;
    return Place{block->buffer.name(), block->bytes_texture.name(),
                 std::size_t(static_cast<const std::uint8_t*>(sample) - block->bytes)};
}

void PictureBuffers::was_read(const void* sample) {
    blocks_->was_read(sample);
}

std::size_t PictureBuffers::bytes() const {
    return blocks_->total_bytes();
}

std::size_t PictureBuffers::count() const {
    return blocks_->count();
}

}  // namespace equistream::gl
