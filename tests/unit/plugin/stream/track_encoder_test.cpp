#include <plugin/stream/track_encoder.h>

#include <gtest/gtest.h>
#include <malloc.h>

#include <vector>

namespace equistream {
namespace {

/// What an allocation finds is what was there before, so that a value nobody set shows in one run of many: here it
/// shows in each.
class FilledAllocations {
public:
    FilledAllocations() { mallopt(M_PERTURB, 0x5a); }
    ~FilledAllocations() { mallopt(M_PERTURB, 0); }
};

struct Times {
    std::int64_t pts = 0, dts = 0;
};

std::vector<Times> times_of(Codec codec, int pictures) {
    av::silence_log();
    const FilledAllocations filled;
    StreamSettings settings;
    settings.codec = codec;
    settings.tracks = {{.width = 64, .height = 64}};
    TrackEncoder encoder(settings, settings.tracks.front(), true);
    std::vector<Times> times;
    const auto take = [&](AVPacket& packet) { times.push_back({packet.pts, packet.dts}); };
    const ByteImage rgb(64, 64, 3, 90);
    const std::vector<std::uint8_t> payload(32, 1);
    for (int i = 0; i < pictures; ++i)
        encoder.encode(encoder.convert(rgb.view()), i, payload, take);
    encoder.drain(take);
    return times;
}

TEST(TrackEncoder, ShortTracksAreDecodedWhenTheirPicturesAre) {
    for (const Codec codec : {Codec::h264, Codec::h265})
        for (const int pictures : {1, 2, 3, 4, 40}) {
            const std::vector<Times> times = times_of(codec, pictures);
            ASSERT_EQ(int(times.size()), pictures);
            for (std::size_t i = 0; i < times.size(); ++i) {
                EXPECT_LE(times[i].dts, times[i].pts) << pictures << " pictures";
                // No earlier than by as many pictures as the decoder is told to put in order.
                EXPECT_GE(times[i].dts, std::int64_t(i) - 2) << pictures << " pictures";
                EXPECT_TRUE(i == 0 || times[i].dts > times[i - 1].dts) << pictures << " pictures";
            }
        }
}

}  // namespace
}  // namespace equistream
