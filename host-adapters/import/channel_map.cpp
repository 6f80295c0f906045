#include "channel_map.h"

#include <equistream/aov.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <set>
#include <string_view>

namespace equistream::files {

namespace {

/// What mirrors and panes show, and what accumulating and denoising leave, is for our own hosts to say: other
/// renderers' channels of such names mean something else.
bool is_imported(const AovInfo& aov) {
    constexpr std::string_view ours[] = {"virtual", "raw", "samples", "variance", "reference"};
    return std::ranges::find(ours, std::string_view(aov.group)) == std::end(ours);
}

std::string lower(std::string text) {
    for (char& c : text)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// A layer of a file: channels whose names differ only in the last word.
struct Layer {
    std::string name;  ///< with its part's and its file's name where channels have none of their own
    std::string last;  ///< its last word, in small letters
    int set = 0;
    std::vector<ForeignChannel> channels;

    static std::string suffix(const ForeignChannel& channel) {
        return channel.plain.substr(channel.plain.rfind('.') + 1);
    }
    /// The channels with these suffixes, in this order, in any letter case; empty if one is missing.
    std::vector<ForeignChannel> with(std::initializer_list<const char*> suffixes) const {
        std::vector<ForeignChannel> found;
        for (const char* wanted : suffixes) {
            const auto at =
                std::ranges::find_if(channels, [&](const auto& c) { return lower(suffix(c)) == lower(wanted); });
            if (at == channels.end())
                return {};
            found.push_back(*at);
        }
        return found;
    }
    std::vector<ForeignChannel> triple() const {
        if (auto rgb = with({"R", "G", "B"}); !rgb.empty())
            return rgb;
        return with({"X", "Y", "Z"});
    }
    std::vector<ForeignChannel> pair() const {
        for (const auto& names : {std::array{"u", "v"}, {"X", "Y"}, {"R", "G"}})
            if (auto found = with({names[0], names[1]}); !found.empty())
                return found;
        return {};
    }
    std::vector<ForeignChannel> single() const {
        return channels.size() == 1 ? channels : std::vector<ForeignChannel>();
    }
};

struct Rule {
    std::string_view plane;
    std::set<std::string> layers;  ///< last words, in small letters
};

const std::vector<Rule>& rules() {
    static const std::vector<Rule> list = {
        {"colour",
         {"", "rgba", "rgb", "combined", "beauty", "color", "colour", "c", "img", "image", "result", "composite"}},
        {"albedo", {"albedo", "alb", "denoising albedo", "diffcol", "diffuse_albedo", "basecolor", "diffuse_color"}},
        {"depth", {"depth", "z", "zdepth", "distance", "dd"}},
        {"normal", {"normal", "normals", "n", "ns", "nn", "sh_normal", "shading_normal"}},
        {"backward", {"backward", "motion_backward", "motionvector", "motion", "velocity", "vector", "mv"}},
        {"forward", {"forward", "motion_forward"}},
        {"object_id", {"object_id", "objectid", "indexob", "object_index"}},
        {"material_id", {"material_id", "materialid", "indexma", "material_index"}},
        {"instance_id", {"instance_id", "instanceid"}},
        {"guide_albedo", {"denoising albedo"}},
        {"guide_normal", {"denoising normal"}},
    };
    return list;
}

std::vector<Layer> layers_of(const std::vector<const ForeignExr*>& files, const std::vector<std::string>& stems,
                             const std::string& view) {
    std::vector<Layer> layers;
    for (std::size_t set = 0; set < files.size(); ++set)
        for (const ForeignChannel& channel : files[set]->channels()) {
            // What names no view is every view's, but for one that has its own.
            const auto is_own = [&](const ForeignChannel& other) {
                return other.view == view && other.plain == channel.plain;
            };
            if (channel.view != view && (!channel.view.empty() || std::ranges::any_of(files[set]->channels(), is_own)))
                continue;
            const std::size_t dot = channel.plain.rfind('.');
            std::string name = dot == std::string::npos ? "" : channel.plain.substr(0, dot);
            // One file an AOV: the file's own name is its layer's.
            if (name.empty() && files.size() > 1)
                name = stems[set];
            const auto same = std::ranges::find_if(
                layers, [&](const Layer& layer) { return layer.name == name && layer.set == int(set); });
            Layer& layer = same == layers.end() ? layers.emplace_back() : *same;
            layer.name = name;
            layer.last = lower(name.substr(name.rfind('.') + 1));
            layer.set = int(set);
            layer.channels.push_back(channel);
        }
    return layers;
}

std::string names_of(const std::vector<ForeignChannel>& channels) {
    std::string text;
    for (const ForeignChannel& channel : channels)
        text += (text.empty() ? "" : " ") + channel.name;
    return text;
}

class Mapper {
public:
    Mapper(std::vector<Layer> layers, const SourceConventions& conventions)
        : layers_(std::move(layers)), conventions_(conventions) {}

    ChannelMap map() {
        for (const auto& [plane, names] : conventions_.channels)
            take_named(plane, names);
        for (const Layer& layer : layers_)
            consider(layer);
        for (const Layer& layer : layers_)
            leave_out_the_rest(layer);
        std::ranges::sort(map_.planes, {}, [](const MappedPlane& p) { return catalogue_position(p.plane); });
        return std::move(map_);
    }

private:
    static std::size_t catalogue_position(std::string_view plane) {
        const auto all = aov_catalogue();
        return std::size_t(std::ranges::find(all, plane, &AovInfo::name) - all.begin());
    }

    bool is_of_our_own() const { return conventions_.name == "equistream"; }

    bool is_wanted(const AovInfo& aov) const {
        const bool is_known = is_imported(aov) || (is_of_our_own() && aov.group == "virtual");
        return is_known && (conventions_.takes_guides || aov.group != "guides");
    }

    bool has(std::string_view plane) const {
        return conventions_.channels.contains(std::string(plane)) ||
               std::ranges::any_of(map_.planes, [&](const MappedPlane& p) { return p.plane == plane; });
    }

    bool is_used(const Layer& layer, const ForeignChannel& channel) const {
        return std::ranges::any_of(map_.planes, [&](const MappedPlane& p) {
            return p.set == layer.set && std::ranges::any_of(p.channels, [&](const ForeignChannel& c) {
                       return c.name == channel.name && c.part_index == channel.part_index;
                   });
        });
    }

    void take(std::string_view plane, const Layer& layer, std::vector<ForeignChannel> channels, std::string why) {
        if (!channels.empty() && !has(plane))
            map_.planes.push_back({std::string(plane), std::move(channels), std::move(why), layer.set});
    }

    void take_named(const std::string& plane, const std::vector<std::string>& names) {
        if (names.empty())
            return;
        MappedPlane mapped{plane, {}, "--channels", -1};
        for (const std::string& name : names)
            for (const Layer& layer : layers_)
                add_named(name, layer, mapped);
        const AovInfo aov = *find_aov(plane);
        const std::size_t needed =
            plane == "depth" && conventions_.depth == DepthKind::position ? 3 : aov.channels.size();
        const bool opaque = plane == "colour" && mapped.channels.size() == 3;
        if (mapped.channels.size() != needed && !opaque)
            throw InputError(expected_found("--channels " + plane, std::to_string(needed) + " channels of one file",
                                            std::to_string(mapped.channels.size()) + " by " + names.front()));
        map_.planes.push_back(std::move(mapped));
    }

    /// A name is a channel, or a layer whose channels come in the plane's order.
    static void add_named(const std::string& name, const Layer& layer, MappedPlane& mapped) {
        if (mapped.set >= 0 && mapped.set != layer.set)
            return;
        const auto channel = std::ranges::find_if(layer.channels, [&](const ForeignChannel& c) {
            return c.name == name || c.plain == name || layer.name + "." + Layer::suffix(c) == name;
        });
        std::vector<ForeignChannel> found;
        if (channel != layer.channels.end())
            found = {*channel};
        else if (layer.name == name)
            found = in_order(layer, mapped.plane);
        if (found.empty())
            return;
        mapped.channels.insert(mapped.channels.end(), found.begin(), found.end());
        mapped.set = layer.set;
    }

    static std::vector<ForeignChannel> in_order(const Layer& layer, std::string_view plane) {
        if (const auto four = layer.with({"X", "Y", "Z", "W"}); plane == "forward" && !four.empty())
            return {four.begin() + 2, four.end()};  // as Cycles has them
        if (plane == "backward" || plane == "forward")
            return layer.pair();
        if (plane == "colour")
            if (auto rgba = layer.with({"R", "G", "B", "A"}); !rgba.empty())
                return rgba;
        auto triple = layer.triple();
        return triple.empty() ? layer.single() : triple;
    }

    void consider(const Layer& layer) {
        if (is_of_our_own())
            return take_ours(layer);
        consider_depth(layer);
        consider_motion(layer);
        for (const Rule& rule : rules()) {
            const AovInfo aov = *find_aov(rule.plane);
            if (!rule.layers.contains(layer.last) || !is_wanted(aov) || rule.plane == "depth" ||
                rule.plane == "backward" || rule.plane == "forward")
                continue;
            const std::string why = layer.name.empty() ? "plain names" : "layer " + layer.name;
            if (aov.type == SampleType::id)
                take(rule.plane, layer, layer.single(), why);
            else if (layer.triple().size() == 3 && !(rule.plane == "colour" && layer.with({"R", "G", "B"}).empty()))
                take(rule.plane, layer, in_order(layer, rule.plane), why);
        }
    }

    /// Our own names are their own reason.
    void take_ours(const Layer& layer) {
        for (const AovInfo& aov : aov_catalogue())
            for (const ForeignChannel& channel : layer.channels)
                if (is_wanted(aov) && channel.name == *aov.channels.begin()) {
                    std::vector<ForeignChannel> found;
                    for (const std::string_view name : aov.channels)
                        for (const ForeignChannel& other : layer.channels)
                            if (other.name == name)
                                found.push_back(other);
                    if (found.size() == aov.channels.size() || (aov.name == "colour" && found.size() == 3))
                        take(aov.name, layer, std::move(found), "equistream's name");
                }
    }

    /// Z, or the only channel; LuxCore writes three that say the same.
    std::vector<ForeignChannel> depth_channel(const Layer& layer) const {
        if (auto z = layer.with({"Z"}); !z.empty())
            return z;
        return conventions_.name == "luxcore" ? layer.with({"R"}) : layer.single();
    }

    void consider_depth(const Layer& layer) {
        if (conventions_.depth == DepthKind::position) {
            if (layer.last == "p" || layer.last == "position")
                take("depth", layer, layer.triple(), "the point itself, layer " + layer.name);
            return;
        }
        if (const auto t = layer.with({"T"}); !t.empty() && conventions_.name == "mitsuba")
            take("depth", layer, t, "Mitsuba's depth ends in T");
        for (const Rule& rule : rules())
            if (rule.plane == "depth" && rule.layers.contains(layer.last))
                take("depth", layer, depth_channel(layer), "layer " + layer.name);
        // Beside X and Y it is part of a colour or a point.
        if (layer.name.empty() && layer.with({"X", "Y"}).empty())
            take("depth", layer, layer.with({"Z"}), "the plain name Z");
    }

    void consider_motion(const Layer& layer) {
        const auto is_in = [&](std::string_view plane) {
            const auto rule = std::ranges::find(rules(), plane, &Rule::plane);
            return rule->layers.contains(layer.last);
        };
        if (!is_in("backward") && !is_in("forward"))
            return;
        const std::vector<ForeignChannel> four = layer.with({"X", "Y", "Z", "W"});
        const bool is_cycles = four.size() == 4;
        if ((is_cycles || is_in("backward")) && conventions_.backward)
            take("backward", layer, is_cycles ? std::vector(four.begin(), four.begin() + 2) : layer.pair(),
                 "layer " + layer.name + ", " + motion_text(*conventions_.backward));
        if ((is_cycles || is_in("forward")) && conventions_.forward)
            take("forward", layer, is_cycles ? std::vector(four.begin() + 2, four.end()) : layer.pair(),
                 "layer " + layer.name + ", " + motion_text(*conventions_.forward));
    }

    static bool is_in_catalogue(const ForeignChannel& channel) {
        return std::ranges::any_of(aov_catalogue(), [&](const AovInfo& aov) {
            return std::ranges::find(aov.channels, channel.name) != aov.channels.end();
        });
    }

    void leave_out_the_rest(const Layer& layer) {
        std::vector<ForeignChannel> rest;
        for (const ForeignChannel& channel : layer.channels)
            if (!is_used(layer, channel))
                rest.push_back(channel);
        if (rest.empty())
            return;
        std::string why = "not a known name; --channels can import it";
        if (layer.last.find("crypto") != std::string::npos)
            why = "import does not read Cryptomatte";
        else if (is_of_our_own() && std::ranges::any_of(rest, is_in_catalogue))
            why = "import does not keep this plane";
        else if (std::ranges::any_of(rules(), [&](const Rule& r) {
                     return (r.plane == "backward" || r.plane == "forward") && r.layers.contains(layer.last) &&
                            !has(r.plane);
                 }))
            why = "motion of unknown convention; set --backward or --forward";
        else
            for (const Rule& rule : rules())
                if (rule.layers.contains(layer.last) && has(rule.plane))
                    why = "another layer already gives plane " + std::string(rule.plane);
        map_.left_out.push_back({names_of(rest), why});
    }

    std::vector<Layer> layers_;
    const SourceConventions& conventions_;
    ChannelMap map_;
};

}  // namespace

std::map<std::string, std::vector<std::string>> parse_channels(const std::string& text) {
    std::map<std::string, std::vector<std::string>> channels;
    for (const std::string_view entry : split_at_commas(text)) {
        const std::size_t equals = entry.find('=');
        const std::string plane(trimmed(entry.substr(0, equals)));
        const auto aov = find_aov(plane);
        if (equals == entry.npos || !aov || !is_imported(*aov)) {
            std::string planes;
            for (const AovInfo& other : aov_catalogue())
                if (is_imported(other))
                    planes += (planes.empty() ? "" : ", ") + std::string(other.name);
            throw InputError(expected_found("--channels", "PLANE=CHANNEL or PLANE=LAYER, PLANE one of " + planes,
                                            "'" + std::string(entry) + "'"));
        }
        std::vector<std::string>& names = channels[plane];
        const std::string_view value = trimmed(entry.substr(equals + 1));
        if (value == "none")
            continue;
        for (std::size_t begin = 0; begin <= value.size();) {
            const std::size_t end = std::min(value.find('+', begin), value.size());
            names.emplace_back(trimmed(value.substr(begin, end - begin)));
            begin = end + 1;
        }
        if (names.front().empty())
            throw InputError(expected_found("--channels " + plane, "a channel, a layer or none", "nothing"));
    }
    return channels;
}

ChannelMap map_channels(const std::vector<const ForeignExr*>& files, const std::vector<std::string>& stems,
                        const std::string& view, const SourceConventions& conventions) {
    return Mapper(layers_of(files, stems, view), conventions).map();
}

}  // namespace equistream::files
