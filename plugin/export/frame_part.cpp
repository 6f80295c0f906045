/// Parts of frames on disk: a line that says what they are of, and the bytes of a film's tiles.
#include "exr_session.h"

#include <equistream/error.h>
#include <equistream/sequence.h>
#include <equistream/sequence_writer.h>

#include <libdeflate.h>

#include <array>
#include <fstream>
#include <string_view>
#include <system_error>
#include <vector>

namespace equistream {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t longest_heading = 256;

fs::path part_file(const fs::path& folder, std::int64_t index) {
    return folder / frame_file_name(index, "part");
}

/// `before`: that of the bytes in front of these.
std::uint32_t checksum_of(std::string_view bytes, std::uint32_t before = 0) {
    return bytes.empty() ? before : libdeflate_crc32(before, bytes.data(), bytes.size());
}

/// A folder that another process renders into, or has removed, is left as it is.
void remove_if_empty(const fs::path& folder) {
    try {
        const FolderLock lock(folder);
        if (!list_frames(folder, "part").empty())
            return;
        std::error_code ignored;
        fs::remove(folder / "manifest.json", ignored);
        fs::remove(folder, ignored);
    } catch (const std::exception&) {
    }
}

}  // namespace

fs::path SequenceWriter::part_folder(std::uint32_t number) const {
    return settings_.folder / ("part-" + std::to_string(number) + "-of-" + std::to_string(settings_.part.count));
}

/// Read in blocks: how many bytes there are to be, the heading alone says.
bool SequenceWriter::has_part(std::int64_t index) const {
    std::ifstream in(part_file(settings_.folder, index), std::ios::binary);
    std::array<char, longest_heading> heading{};
    if (!in.getline(heading.data(), heading.size()))
        return false;
    std::vector<char> block(std::size_t{1} << 20);
    std::uint64_t bytes = 0;
    std::uint32_t checksum = 0;
    while (in) {
        in.read(block.data(), static_cast<std::streamsize>(block.size()));
        const auto count = static_cast<std::size_t>(in.gcount());
        checksum = checksum_of({block.data(), count}, checksum);
        bytes += count;
    }
    return in.eof() &&
           heading.data() + std::string("\n") == part_heading(index, settings_.part.number, bytes, checksum);
}

/// The fingerprint covers size, planes and the renderer's code, so nothing else of the bytes is to be checked.
std::string SequenceWriter::part_heading(std::int64_t index, std::uint32_t number, std::uint64_t bytes,
                                         std::uint32_t checksum) const {
    return "equistream part 2: frame " + std::to_string(index) + ", part " + std::to_string(number) + " of " +
           std::to_string(settings_.part.count) + ", tiles of " + std::to_string(settings_.tile_side) + ", " +
           std::to_string(settings_.manifest.shared.samples_per_pixel) + " spp, settings " +
           settings_.manifest.fingerprint + ", " + std::to_string(bytes) + " bytes, checksum " +
           std::to_string(checksum) + "\n";
}

void SequenceWriter::write_part(const FrameInfo& info, const std::string& bytes) {
    const std::string heading = part_heading(info.index, settings_.part.number, bytes.size(), checksum_of(bytes));
    AtomicFile file(part_file(settings_.folder, info.index));
    file.write_at(heading.data(), heading.size(), 0);
    file.write_at(bytes.data(), bytes.size(), heading.size());
    file.commit([&] { make_way_for(info); });
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
        refuse("a readable file", "a read error");
    if (const std::string expected = part_heading(index, number, bytes.size(), checksum_of(bytes)); heading != expected)
        refuse("'" + expected.substr(0, expected.size() - 1) + "'", "another heading, or damaged bytes");
    return bytes;
}

void SequenceWriter::remove_parts(std::int64_t index) const {
    std::error_code ignored;
    for (std::uint32_t number = 1; number <= settings_.part.count; ++number) {
        const fs::path folder = part_folder(number);
        fs::remove(part_file(folder, index), ignored);
        remove_if_empty(folder);
    }
}

}  // namespace equistream
