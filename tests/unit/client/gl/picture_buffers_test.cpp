/// Pictures that decoders write into the driver's own buffers, and that the GPU reads there.
#include "gl_fixture.h"
#include "made_objects.h"

#include <client/warp/gl/source_textures.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <equistream/colour.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <future>
#include <utility>
#include <vector>

namespace equistream::test {
namespace {

using GlPictureBuffers = Gl;

constexpr std::size_t some_bytes = 4096;

/// Asked for until there is some.
std::shared_ptr<std::uint8_t> taken(gl::PictureBuffers& buffers, std::size_t bytes) {
    if (auto memory = buffers.take(bytes))
        return memory;
    buffers.provide();
    return buffers.take(bytes);
}

/// What a call of the driver's is replaced by while this lives; it must have been called before.
template <auto& call>
class Replaced {
public:
    explicit Replaced(std::remove_reference_t<decltype(call)> by) : original_(std::exchange(call, by)) {}
    ~Replaced() { call = original_; }
    Replaced(const Replaced&) = delete;
    Replaced& operator=(const Replaced&) = delete;

private:
    std::remove_reference_t<decltype(call)> original_;
};

/// As if the GPU took for ever.
GLenum still_working(GLsync, GLbitfield, GLuint64) {
    return GL_TIMEOUT_EXPIRED;
}
void* no_mapping(GLuint, GLintptr, GLsizeiptr, GLbitfield) {
    return nullptr;
}
/// As drivers answer whose limit has more than 32 bits.
void no_integer(GLenum, GLint* value) {
    *value = -4;
}

ByteImage downloaded(const gl::SourceTextures& textures) {
    ByteImage rgba(textures.size().width, textures.size().height, 4);
    glGetTextureImage(textures.colour(), 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(rgba.samples().size()),
                      rgba.samples().data());
    return rgba;
}

SourceView view_of(const DecodedPicture& picture) {
    return {.yuv = picture.yuv.planes, .camera = EquirectCamera{picture.width, picture.height, {}}};
}

/// Frames of a stream as the viewer shows them, each beside the same one that was copied. How many were read in place.
int expect_same_pictures(const std::filesystem::path& file, const std::shared_ptr<gl::PictureBuffers>& buffers) {
    StreamReader there(file.string(), {.yuv = true, .pq = true, .memory = buffers});
    StreamReader elsewhere(file.string(), {.yuv = true, .pq = true});
    gl::SourceTextures in_place, by_gpu(gl::PlaneReader::gpu), by_cpu(gl::PlaneReader::cpu);
    const auto display = std::make_shared<gl::PqDisplay>(HdrDisplay());
    in_place.read_in_place(buffers);
    in_place.show_pq_by(display);
    by_gpu.show_pq_by(display);
    int read_in_place = 0;
    std::deque<DecodedPicture> shown;  // gaps are filled from the one before
    while (auto picture = there.next()) {
        const auto expected = elsewhere.next();
        buffers->provide();
        const SourceView view = view_of(*picture);
        const void* const first =
            picture->pq.empty() ? static_cast<const void*>(picture->yuv.planes.y.data) : picture->pq.planes.y.data;
        read_in_place += buffers->find(first).has_value();
        in_place.upload(view, picture->pq.planes);
        by_gpu.upload(view_of(*expected), expected->pq.planes);
        const ByteImage found = downloaded(in_place);
        EXPECT_TRUE(std::ranges::equal(found.samples(), downloaded(by_gpu).samples()));
        if (picture->pq.empty()) {
            by_cpu.upload(view_of(*expected));
            EXPECT_TRUE(std::ranges::equal(found.samples(), downloaded(by_cpu).samples()));
        }
        shown.push_back(std::move(*picture));
        if (shown.size() > 2)
            shown.pop_front();
    }
    EXPECT_FALSE(elsewhere.next());
    return read_in_place;
}

synthetic::Made stream_of(int width, int height, int pictures) {
    synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    made.settings.tracks = {{TrackRole::main, width, height}};
    made.settings.preset = "ultrafast";
    made.pictures = pictures;
    made.settings.pictures = std::uint32_t(pictures);
    return made;
}

TEST_F(GlPictureBuffers, ShowTheSamePictures) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", stream_of(200, 100, 60));
    const auto buffers = std::make_shared<gl::PictureBuffers>();
    EXPECT_GT(expect_same_pictures(folder / "a.mkv", buffers), 10);
}

TEST_F(GlPictureBuffers, ShowTheSameHdrPictures) {
    const synthetic::Folder folder;
    StreamSettings settings;
    settings.codec = Codec::h265;
    settings.transfer = Transfer::pq;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 136, 72}};
    StreamWriter writer((folder / "a.mkv").string(), settings);
    for (int index = 0; index < 40; ++index) {
        FloatImage pq(136, 72, 3);
        for (std::size_t i = 0; i < pq.samples().size(); ++i)
            pq.samples()[i] = float((i * 7 + std::size_t(index) * 100) % 997) / 997;
        writer.write_pq(TrackRole::main, pq.view(), synthetic::info(136, 72, index));
    }
    writer.finish();
    const auto buffers = std::make_shared<gl::PictureBuffers>();
    EXPECT_GT(expect_same_pictures(folder / "a.mkv", buffers), 5);
}

TEST_F(GlPictureBuffers, DoNotGrowWithTheFrames) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", stream_of(96, 64, 500));
    const auto buffers = std::make_shared<gl::PictureBuffers>();
    EXPECT_GT(expect_same_pictures(folder / "a.mkv", buffers), 400);
    EXPECT_LE(buffers->count(), 32u) << "what a decoder and a viewer hold at once";
}

TEST_F(GlPictureBuffers, WithoutMappingNobodyNotices) {
    const synthetic::Folder folder;
    synthetic::write(folder / "a.mkv", stream_of(96, 64, 20));
    {
        gl::PictureBuffers called;
        taken(called, some_bytes);
    }
    const Replaced<epoxy_glMapNamedBufferRange> none(no_mapping);
    const auto buffers = std::make_shared<gl::PictureBuffers>();
    EXPECT_EQ(expect_same_pictures(folder / "a.mkv", buffers), 0);
    EXPECT_EQ(buffers->count(), 0u);
}

TEST_F(GlPictureBuffers, AreNotWrittenOverWhileTheGpuReads) {
    gl::PictureBuffers buffers;
    auto memory = taken(buffers, some_bytes);
    ASSERT_NE(memory, nullptr);
    std::uint8_t* const first = memory.get();
    buffers.was_read(first + 17);
    buffers.provide();  // which asks the driver for the first time
    std::vector<std::shared_ptr<std::uint8_t>> others;
    const auto is_handed_out = [&] {
        others.push_back(taken(buffers, some_bytes));
        return others.back().get() == first;
    };
    EXPECT_FALSE(is_handed_out()) << "it is held";
    {
        buffers.was_read(first);
        const Replaced<epoxy_glClientWaitSync> never(still_working);
        memory.reset();
        for (int i = 0; i < 3; ++i)
            EXPECT_FALSE(is_handed_out()) << "it is still read";
    }
    glFinish();
    buffers.provide();
    EXPECT_TRUE(is_handed_out());
}

TEST_F(GlPictureBuffers, OfAnotherSizeTakeThePlaceOfThoseBefore) {
    gl::PictureBuffers buffers;
    for (const std::size_t bytes : {some_bytes, 5 * some_bytes, 2 * some_bytes}) {
        for (int i = 0; i < 2 * gl::PictureBuffers::max_rounds_unused; ++i) {
            const auto one = taken(buffers, bytes), other = taken(buffers, bytes);
            ASSERT_TRUE(one && other && one != other);
            buffers.provide();
        }
        EXPECT_EQ(buffers.count(), 2u);
        EXPECT_EQ(buffers.bytes(), 2 * bytes);
    }
}

/// While the driver makes a buffer, however long that takes.
TEST_F(GlPictureBuffers, DecodersDoNotWaitForTheDriver) {
    static gl::PictureBuffers* buffers;
    static decltype(epoxy_glMapNamedBufferRange) map;
    static std::future<void> decoder;
    static bool has_answered;
    gl::PictureBuffers asked;
    taken(asked, some_bytes);  // which maps for the first time
    buffers = &asked;
    map = epoxy_glMapNamedBufferRange;
    const Replaced<epoxy_glMapNamedBufferRange> slow(
        [](GLuint buffer, GLintptr offset, GLsizeiptr bytes, GLbitfield to) {
            decoder = std::async(std::launch::async, [] { buffers->take(3 * some_bytes); });
            has_answered = decoder.wait_for(std::chrono::seconds(2)) == std::future_status::ready;
            return map(buffer, offset, bytes, to);
        });
    EXPECT_NE(taken(asked, 2 * some_bytes), nullptr);
    EXPECT_TRUE(has_answered);
    decoder.wait();
}

/// Where buffers run short now and then, some pictures lie there and some do not.
TEST_F(GlPictureBuffers, PicturesThereAndElsewhereKeepTheirStorage) {
    const auto buffers = std::make_shared<gl::PictureBuffers>();
    constexpr int width = 96, height = 64, luma = width * height;
    const auto there = taken(*buffers, luma * 3 / 2);
    ASSERT_NE(there, nullptr);
    std::fill_n(there.get(), luma * 3 / 2, std::uint8_t{200});
    const std::vector<std::uint8_t> elsewhere(luma * 3 / 2, 90);
    gl::SourceTextures textures(gl::PlaneReader::gpu);
    textures.read_in_place(buffers);
    const auto shown = [&](const std::uint8_t* y) {
        const std::uint8_t *cb = y + luma, *cr = cb + luma / 4;
        textures.upload({.yuv = {{y, width, height, 1, width},
                                 {cb, width / 2, height / 2, 1, width / 2},
                                 {cr, width / 2, height / 2, 1, width / 2}},
                         .camera = EquirectCamera{width, height, {}}});
        return downloaded(textures);
    };
    const ByteImage first = shown(there.get()), second = shown(elsewhere.data());
    EXPECT_FALSE(std::ranges::equal(first.samples(), second.samples()));
    GLuint framebuffer = 0;
    glCreateFramebuffers(1, &framebuffer);
    const gl::Framebuffer owner(framebuffer);
    const MadeObjects made;
    for (int i = 0; i < 2; ++i) {
        EXPECT_TRUE(std::ranges::equal(shown(there.get()).samples(), first.samples()));
        EXPECT_TRUE(std::ranges::equal(shown(elsewhere.data()).samples(), second.samples()));
    }
    EXPECT_EQ(made.count(), 0);
}

/// A driver's memory is not filled with what nobody reads, and what is too large lies elsewhere.
TEST_F(GlPictureBuffers, HaveTheirLimits) {
    gl::PictureBuffers buffers;
    for (int i = 0; i < 1000; ++i)
        EXPECT_EQ(buffers.take(some_bytes), nullptr);
    buffers.provide();
    EXPECT_EQ(buffers.count(), gl::PictureBuffers::max_wanted);
    GLint max_texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &max_texels);
    EXPECT_EQ(taken(buffers, std::size_t(max_texels) + 1), nullptr);
    EXPECT_EQ(taken(buffers, gl::PictureBuffers::max_bytes), nullptr);
    EXPECT_NE(taken(buffers, 2 * some_bytes), nullptr) << "which is no reason to map nothing more";
    const Replaced<epoxy_glGetIntegerv> lost(no_integer);
    EXPECT_EQ(taken(buffers, std::size_t(max_texels) + 1), nullptr);
    EXPECT_NE(taken(buffers, 3 * some_bytes), nullptr) << "nor is one that has no room for its limit";
}

/// Decoders that are still there when the viewer is not.
TEST_F(GlPictureBuffers, GiveNothingAfterTheirEnd) {
    std::shared_ptr<std::uint8_t> memory;
    {
        gl::PictureBuffers buffers;
        memory = taken(buffers, some_bytes);
        ASSERT_NE(memory, nullptr);
    }
    memory.reset();
}

}  // namespace
}  // namespace equistream::test
