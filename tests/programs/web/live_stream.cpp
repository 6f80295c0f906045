/// Codes rendered frames as `equistream serve` does, one after the other: equistream_live_stream OUT.mkv [FRAME.exr
/// WINDOW.exr]... It removes the frames.
#include <programs/serve/live_encoder.h>

#include <cstdio>
#include <exception>
#include <fstream>

int main(int argc, char** argv) {
    using equistream::serve::LiveEncoder;
    try {
        std::ofstream out(argc > 1 ? argv[1] : "", std::ios::binary);
        LiveEncoder encoder({});
        for (int i = 2; i + 1 < argc; i += 2) {
            const LiveEncoder::Coded coded = encoder.encode(argv[i], argv[i + 1], false, 0, i);
            out << coded.header << coded.bytes;
        }
        out << encoder.finish() << std::flush;
        return out ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "equistream_live_stream: %s\n", error.what());
        return 1;
    }
}
