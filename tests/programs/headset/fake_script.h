#pragma once
/// What the runtime for tests is told to do: `script.txt` of its folder, read once.
#include <openxr/openxr.h>

#include <cstdint>
#include <string>
#include <vector>

namespace fake {

/// Tangents in sixteenths; wider outwards and downwards, as headsets are.
struct Tangents {
    float out = 17, in = 13, up = 14, down = 18;
};

enum class Seen { by_somebody, by_nobody, untracked };

/// What happens to the session once a frame was submitted.
enum class Then { next, stop, exit, loss, instance_loss, lost_call };

struct Frame {
    Seen seen = Seen::by_somebody;
    XrPosef head{{0, 0, 0, 1}, {0, 0, 0}};
    Tangents fov;
    float ipd_m = 0.064f, cant_rad = 0;
    std::string until;        ///< it is asked for again until a file of that name is there; empty: once
    Then then = Then::next;   ///< of the last one never `next`
    std::string ready_until;  ///< after `stop`: ready again once a file of that name is there; empty: at once
    int recentred_after = 0;  ///< frames after this one LOCAL begins anew, which is said now; 0: it does not
};

struct Script {
    std::vector<Frame> frames;
    bool has_headset = true, has_opengl = true, has_srgb = true;
    std::int64_t lead_ns = 0;  ///< frames are seen so long after any time that is asked for; 0: it tells no times

    /// False where a line is none of those that fake_runtime.cpp lists.
    bool read(const std::string& file);

private:
    bool read_line(const std::string& line, Frame& like);
};

}  // namespace fake
