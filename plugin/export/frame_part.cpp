/// Parts of frames on disk: a line that says what they are of, and the bytes of a film's tiles.
#include "exr_session.h"

#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/sequence_writer.h>

#include <isa-l/crc.h>

#include <fstream>
#include <system_error>

namespace equistream {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t longest_heading = 256;

fs::path part_file(const fs::path& folder, std::int64_t index) {
    return folder / frame_file_name(index, "part");
}

}  // namespace

fs::path SequenceWriter::part_folder(std::uint32_t number) const {
    return settings_.folder / ("part-" + std::to_string(number) + "-of-" + std::to_string(settings_.part.count));
}

bool SequenceWriter::has_part(std::int64_t index) const {
    return fs::exists(part_file(settings_.folder, index));
}

/// The fingerprint covers size, planes, samples and the renderer's code, so nothing else of the bytes is to be checked.
std::string SequenceWriter::part_heading(std::int64_t index, std::uint32_t number, const std::string& bytes) const {
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    return "equistream part 1: frame " + std::to_string(index) + ", part " + std::to_string(number) + " of " +
           std::to_string(settings_.part.count) + ", settings " + settings_.manifest.fingerprint + ", " +
           std::to_string(bytes.size()) + " bytes, checksum " + std::to_string(crc32_gzip_refl(0, data, bytes.size())) +
           "\n";
}

void SequenceWriter::write_part(const FrameInfo& info, const std::string& bytes) {
    if (!manifest_is_current_)  // another one's, where parts of other settings make way
        write_manifest(settings_.folder, settings_.manifest);
    manifest_is_current_ = true;
    const std::string heading = part_heading(info.index, settings_.part.number, bytes);
    AtomicFile file(part_file(settings_.folder, info.index));
    file.write_at(heading.data(), heading.size(), 0);
    file.write_at(bytes.data(), bytes.size(), heading.size());
    file.commit();
}

std::string SequenceWriter::read_part(std::int64_t index, std::uint32_t number, std::size_t size) const {
    const fs::path file = part_file(part_folder(number), index);
    const auto refuse = [&](const std::string& expected, const std::string& found) {
        throw InputError(expected_found(file.string(), expected, found) + "; render this part again");
    };
    std::error_code error;
    const std::uintmax_t there = fs::file_size(file, error);
    if (error)
        refuse("part " + std::to_string(number) + " of the frame", error.message());
    if (there < size || there > size + longest_heading)
        refuse("a heading and " + std::to_string(size) + " bytes", std::to_string(there) + " bytes");
    std::ifstream in(file, std::ios::binary);
    std::string heading(static_cast<std::size_t>(there) - size, '\0'), bytes(size, '\0');
    in.read(heading.data(), static_cast<std::streamsize>(heading.size()));
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    if (!in)
        refuse("a file that can be read", "an error");
    if (const std::string expected = part_heading(index, number, bytes); heading != expected)
        refuse("'" + expected.substr(0, expected.size() - 1) + "'", "another heading, or other bytes than it says");
    return bytes;
}

void SequenceWriter::remove_parts(std::int64_t index) const {
    std::error_code ignored;
    for (std::uint32_t number = 1; number <= settings_.part.count; ++number) {
        const fs::path folder = part_folder(number);
        fs::remove(part_file(folder, index), ignored);
        if (fs::exists(folder, ignored) && list_frames(folder, "part").empty()) {
            fs::remove(folder / "manifest.json", ignored);
            fs::remove(folder, ignored);
        }
    }
}

}  // namespace equistream
