#pragma once
/// What is fuzzed. A target reads bytes that came from outside; it may return or throw an InputError or WorkError of
/// one line. Anything else (another exception, a sanitizer's report, a claim that does not hold) is a find.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::fuzz {

using Bytes = std::span<const std::uint8_t>;
using Seeds = std::vector<std::vector<std::uint8_t>>;

struct Target {
    std::string_view name;
    void (*read)(Bytes);
    Seeds (*seeds)();  ///< small whole inputs, the same every time
    int rounds;        ///< of each kind of damage that fuzz_test tries: about a second's work
    /// Changes the input where its structure is known. Null: nothing is known of it.
    void (*damage)(std::vector<std::uint8_t>&, std::mt19937& random) = nullptr;
    /// Counts what each seed is to reach; null: being accepted says enough.
    const int* reached = nullptr;
};

std::span<const Target> targets();

/// Runs the target on its own exact-size copy of the bytes. Empty: they were accepted; else why not. Throws for a find.
std::string refusal_of(const Target& target, Bytes bytes);

/// Throws std::logic_error: what was read does not keep its promise.
void require(bool holds, const char* promise);

/// `bytes` as a file of this process's own temporary folder; the same name is the same file.
std::filesystem::path scratch_file(const std::string& name, Bytes bytes);

/// What bytes choose, one after the other; zeros once they have come to their end.
class Choices {
public:
    explicit Choices(Bytes bytes) : left_(bytes) {}

    bool are_over() const { return left_.empty(); }
    template <typename Number>
    Number take() {
        Number number{};
        const Bytes bytes = take_bytes(sizeof number);
        if (!bytes.empty())
            std::memcpy(&number, bytes.data(), bytes.size());
        return number;
    }
    /// From 0 to `count` - 1.
    int below(int count) { return take<std::uint8_t>() % count; }
    bool yes() { return below(2) == 1; }
    /// Of an array.
    template <typename Values>
    auto one_of(const Values& values) {
        return values[std::size_t(below(int(std::size(values))))];
    }
    /// Fewer, where no more are left.
    Bytes take_bytes(std::size_t count) {
        const Bytes taken = left_.first(std::min(count, left_.size()));
        left_ = left_.subspan(taken.size());
        return taken;
    }

private:
    Bytes left_;
};

/// Sets a number to one that is often wrong, or flips a bit, in the `reach` bytes behind one of the places where
/// `bytes` have `mark`.
void damage_behind(Bytes mark, std::size_t reach, std::span<std::uint8_t> bytes, std::mt19937& random);
/// The same in what coded pictures say of themselves (SEI), wherever it lies.
void damage_frame_data(std::vector<std::uint8_t>& bytes, std::mt19937& random);
/// Of a text: puts one of `words`, or a value that is often wrong, before a word or in place of it or of what brackets
/// hold; or takes its line away or repeats it.
void damage_text(std::span<const std::string_view> words, std::vector<std::uint8_t>& bytes, std::mt19937& random);
/// Of an EXR file: what one of its attributes says, or that it is there.
void damage_attributes(std::vector<std::uint8_t>& bytes, std::mt19937& random);

/// For seeds.
std::vector<std::uint8_t> bytes_of(std::string_view text);
std::vector<std::uint8_t> bytes_of_file(const std::filesystem::path& file);

extern const Target command_lines_target;
extern const Target frame_data_target;
extern const Target manifest_target;
extern const Target scene_target;
extern const Target path_target;
extern const Target model_target;
extern const Target obj_target;
extern const Target exr_target;
extern const Target foreign_exr_target;
extern const Target stream_target;
extern const Target shown_frames_target;
extern const Target viewer_messages_target;
extern const Target served_file_target;
extern const Target plugin_calls_target;
extern const Target client_calls_target;
extern const Target client_model_target;

}  // namespace equistream::fuzz
