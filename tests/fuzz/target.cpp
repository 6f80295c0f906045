#include "target.h"

#include <equistream/error.h>
#include <equistream/stream.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <limits>
#include <stdexcept>

namespace equistream::fuzz {

namespace {

class ScratchFolder {
public:
    ScratchFolder() {
        // In memory where there is such a folder: files are written by the thousand.
        const std::filesystem::path memory = "/dev/shm";
        const std::filesystem::path place =
            std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path();
        std::string name = (place / "equistream-fuzz-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr)
            throw std::runtime_error("no temporary folder");
        path_ = name;
    }
    ~ScratchFolder() { std::filesystem::remove_all(path_); }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    const std::filesystem::path& path() const { return path_; }

private:
    std::filesystem::path path_;
};

void check_refusal(const std::string& line) {
    require(!line.empty() && line.size() < 10000, "a refusal is neither empty nor endless");
    for (const char c : line)
        require(static_cast<unsigned char>(c) >= 0x20, "a refusal is one line without control characters");
}

}  // namespace

std::span<const Target> targets() {
    static const std::array all = {
        command_lines_target, frame_data_target,   manifest_target,     scene_target,
        path_target,          model_target,        obj_target,          exr_target,
        foreign_exr_target,   stream_target,       shown_frames_target, viewer_messages_target,
        served_file_target,   plugin_calls_target, client_calls_target, client_model_target};
    return all;
}

std::string refusal_of(const Target& target, Bytes bytes) {
    const std::vector<std::uint8_t> copy(bytes.begin(), bytes.end());
    std::string refusal;
    try {
        target.read(copy);
        return refusal;
    } catch (const InputError& error) {
        refusal = error.what();
    } catch (const WorkError& error) {
        refusal = error.what();
    }
    check_refusal(refusal);
    return refusal;
}

void require(bool holds, const char* promise) {
    if (!holds)
        throw std::logic_error(promise);
}

void damage_behind(Bytes mark, std::size_t reach, std::span<std::uint8_t> bytes, std::mt19937& random) {
    std::vector<std::size_t> places;
    for (auto at = bytes.begin(); (at = std::search(at, bytes.end(), mark.begin(), mark.end())) != bytes.end(); ++at)
        places.push_back(std::size_t(at - bytes.begin()) + mark.size());
    if (places.empty())
        return;
    const std::span<std::uint8_t> behind = bytes.subspan(places[random() % places.size()]);
    const std::span<std::uint8_t> there = behind.first(std::min(reach, behind.size()));
    const auto set = [&](const auto& value) {
        if (there.size() >= sizeof value)
            std::memcpy(&there[random() % (there.size() - sizeof value + 1)], &value, sizeof value);
    };
    constexpr double inf = std::numeric_limits<double>::infinity();
    constexpr std::array numbers = {
        0.0, -1.0, 1.0, 1e-30, 1e30, 1e300, inf, -inf, std::numeric_limits<double>::quiet_NaN()};
    const double number = numbers[random() % numbers.size()];
    switch (random() % 5) {
    case 0:
        set(number);
        break;
    case 1:
        set(float(std::clamp(number, -3e38, 3e38)));
        break;
    case 2:
        set(std::uint16_t(random()));
        break;
    case 3:
        set(std::uint32_t(random() % 3 == 0 ? 0xffffffffu : random() % 300));
        break;
    default:
        if (!there.empty())
            there[random() % there.size()] ^= std::uint8_t(1u << random() % 8);
    }
}

void damage_frame_data(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    constexpr std::size_t uuid_bytes = 16, max_bytes = 500;
    static const std::vector<std::uint8_t> data = encode_frame_info(TrackRole::main, {});
    damage_behind(Bytes(data).first(uuid_bytes), max_bytes, bytes, random);
}

namespace {

/// First and last byte but one of each word of a text, and of what each bracket holds.
std::vector<std::pair<std::size_t, std::size_t>> parts_of(std::string_view text) {
    constexpr std::string_view between = " \t\r\n,:=/[]{}", opening = "[{", closing = "]}";
    std::vector<std::pair<std::size_t, std::size_t>> parts;
    std::vector<std::size_t> open;
    for (std::size_t at = 0; at < text.size(); ++at) {
        if (opening.find(text[at]) != opening.npos) {
            open.push_back(at);
        } else if (closing.find(text[at]) != closing.npos && !open.empty()) {
            parts.emplace_back(open.back(), at + 1);
            open.pop_back();
        }
        const bool is_word = between.find(text[at]) == between.npos && text[at] != '\0';
        if (!is_word)
            continue;
        const std::size_t end = std::min({text.find_first_of(between, at), text.find('\0', at), text.size()});
        parts.emplace_back(at, end);
        at = end - 1;
    }
    return parts;
}

}  // namespace

void damage_text(std::span<const std::string_view> words, std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    constexpr std::array<std::string_view, 24> wrong = {
        "",     "0",     "-1",   "1",  "2",  "0.5", "1e9",       "-1e300", "1e39",  "4294967296", "1e999", "nan",
        "null", "false", "\"\"", "[]", "{}", "[0]", "[0, 1, 0]", "[[]]",   "\"x\"", "\xff",       "x",     "-inf"};
    std::string text(bytes.begin(), bytes.end());
    const auto parts = parts_of(text);
    if (parts.empty())
        return;
    const auto [begin, end] = parts[random() % parts.size()];
    const bool own = !words.empty() && random() % 2 == 0;
    const std::string_view word = own ? words[random() % words.size()] : wrong[random() % wrong.size()];
    const std::size_t line = begin == 0 ? 0 : text.rfind('\n', begin - 1) + 1;  // npos + 1 is 0
    const std::size_t line_end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    switch (random() % 8) {
    case 0:
        text.insert(begin, std::string(word) + " ");
        break;
    case 1:
        text.erase(line, line_end - line);
        break;
    case 2:
        text.insert(line, text.substr(line, line_end - line));
        break;
    default:
        text.replace(begin, end - begin, word);
    }
    bytes.assign(text.begin(), text.end());
}

std::filesystem::path scratch_file(const std::string& name, Bytes bytes) {
    static const ScratchFolder folder;
    const std::filesystem::path file = folder.path() / name;
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    out.close();
    require(out.good(), "the temporary folder can be written");
    return file;
}

std::vector<std::uint8_t> bytes_of(std::string_view text) {
    return {text.begin(), text.end()};
}

std::vector<std::uint8_t> bytes_of_file(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    require(!text.empty(), "a seed was written");
    return bytes_of(text);
}

}  // namespace equistream::fuzz
