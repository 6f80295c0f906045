#include "fake_script.h"

#include <fstream>
#include <sstream>

namespace fake {

namespace {

constexpr float rad_per_degree = 0.017453293f;

}  // namespace

/// `like` has what the frames from here on have in common.
bool Script::read_line(const std::string& line, Frame& like) {
    std::istringstream words(line);
    std::string verb, name;
    words >> verb;
    const auto is_after_a_frame = [&] { return !frames.empty(); };
    const auto add = [&](Seen seen) {
        frames.push_back(like);
        frames.back().seen = seen;
        return true;
    };
    const auto ends = [&](Then then) {
        if (is_after_a_frame())
            frames.back().then = then;
        return is_after_a_frame();
    };
    if (verb == "idle")
        return add(Seen::by_nobody);
    if (verb == "untracked")
        return add(Seen::untracked);
    if (verb == "until")
        return is_after_a_frame() && words >> frames.back().until;
    if (verb == "recentre")
        return is_after_a_frame() && words >> frames.back().recentred_after;
    if (verb == "stop") {
        if (words >> name && is_after_a_frame())
            frames.back().ready_until = name;
        return ends(Then::stop);
    }
    if (verb == "exit")
        return ends(Then::exit);
    if (verb == "loss")
        return ends(Then::loss);
    if (verb == "instance-loss")
        return ends(Then::instance_loss);
    if (verb == "lost-call")
        return ends(Then::lost_call);
    if (verb == "fov")
        return bool(words >> like.fov.out >> like.fov.in >> like.fov.up >> like.fov.down);
    if (verb == "ipd")
        return bool(words >> like.ipd_m);
    if (verb == "cant") {
        float degrees = 0;
        const bool is_whole = bool(words >> degrees);
        like.cant_rad = degrees * rad_per_degree;
        return is_whole;
    }
    if (verb == "lead-ms") {
        std::int64_t ms = 0;
        const bool is_whole = bool(words >> ms);
        lead_ns = 1'000'000 * ms;
        return is_whole;
    }
    if (verb == "no") {
        words >> name;
        bool* const has = name == "headset"  ? &has_headset
                          : name == "opengl" ? &has_opengl
                          : name == "srgb"   ? &has_srgb
                                             : nullptr;
        if (has != nullptr)
            *has = false;
        return has != nullptr;
    }
    std::istringstream numbers(line);
    auto& [q, p] = like.head;
    return numbers >> p.x >> p.y >> p.z >> q.w >> q.x >> q.y >> q.z && add(Seen::by_somebody);
}

bool Script::read(const std::string& file) {
    std::ifstream text(file);
    std::string line;
    Frame like;
    while (std::getline(text, line))
        if (!read_line(line, like))
            return false;
    return frames.empty() ? !has_headset || !has_opengl : frames.back().then != Then::next;
}

}  // namespace fake
