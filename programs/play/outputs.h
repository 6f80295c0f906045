#pragma once
/// Every file of a run.
#include "frame_player.h"
#include "report.h"
#include "view_writer.h"

#include <equistream/locks.h>

#include <cstdint>
#include <filesystem>
#include <optional>

namespace equistream::play {

class Outputs {
public:
    /// Views of an earlier run of the same settings make way, others only with --overwrite. Throws InputError where
    /// they stay, or where the folder holds what is played or rendered frames.
    explicit Outputs(const Settings& settings);

    void write(const PlayedFrame& frame);
    void finish() { eyes_->finish(); }
    /// Beside the views; one video has none.
    void write_report(const Report& report) const;
    std::int64_t bytes() const { return eyes_->bytes(); }

private:
    void prepare_folder(const Settings& settings);

    std::filesystem::path out_;
    bool is_video_;
    std::optional<FolderLock> lock_;  // two runs would leave a mixture
    std::optional<EyesWriter> eyes_;
};

}  // namespace equistream::play
