#include "exr_compress.h"

#include <isa-l/igzip_lib.h>

namespace equistream {

struct ZipCompressor::State {
    isal_zstream stream{};
    std::vector<std::uint8_t> predicted;
    std::vector<std::uint8_t> level_buffer = std::vector<std::uint8_t>(ISAL_DEF_LVL1_DEFAULT);
};

ZipCompressor::ZipCompressor() : state_(std::make_unique<State>()) {}
ZipCompressor::~ZipCompressor() = default;

namespace {

/// EXR's predictor: even bytes first, then odd ones, then each byte's difference from the one before it (+128).
void predict(std::span<const std::uint8_t> in, std::vector<std::uint8_t>& out) {
    out.resize(in.size());
    const std::size_t half = (in.size() + 1) / 2;
    for (std::size_t i = 0; i < in.size() / 2; ++i) {
        out[i] = in[2 * i];
        out[half + i] = in[2 * i + 1];
    }
    if (in.size() % 2 != 0)
        out[half - 1] = in[in.size() - 1];
    std::uint8_t previous = out.empty() ? std::uint8_t{0} : out[0];
    for (std::size_t i = 1; i < out.size(); ++i) {
        const std::uint8_t current = out[i];
        out[i] = static_cast<std::uint8_t>(current - previous + 128);
        previous = current;
    }
}

}  // namespace

void ZipCompressor::compress(std::span<const std::uint8_t> packed, std::vector<std::uint8_t>& out) {
    predict(packed, state_->predicted);
    out.resize(packed.size());
    isal_zstream& stream = state_->stream;
    isal_deflate_stateless_init(&stream);
    stream.level = 1;
    stream.level_buf = state_->level_buffer.data();
    stream.level_buf_size = static_cast<std::uint32_t>(state_->level_buffer.size());
    stream.gzip_flag = IGZIP_ZLIB;
    stream.flush = NO_FLUSH;
    stream.end_of_stream = 1;
    stream.next_in = state_->predicted.data();
    stream.avail_in = static_cast<std::uint32_t>(packed.size());
    stream.next_out = out.data();
    stream.avail_out = static_cast<std::uint32_t>(out.size());
    const bool done = isal_deflate_stateless(&stream) == COMP_OK;
    if (done && stream.total_out < packed.size())
        out.resize(stream.total_out);
    else
        out.assign(packed.begin(), packed.end());
}

}  // namespace equistream
