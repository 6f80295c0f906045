#pragma once
/// Rendered frames to the bytes of a live stream: Matroska, a cluster a frame; main and the window within it, where
/// there is one, each with its depth. One thread at a time.
#include <equistream/bound.h>
#include <equistream/colour.h>
#include <equistream/depth_code.h>
#include <equistream/stream.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace equistream::serve {

struct LiveCoding {
    double crf = StreamSettings{}.crf;
    std::string preset = "veryfast";
    bool depth = true;
    DepthCodeId depth_code = DepthCodeId::w10;
    /// In scene time. The server begins one for a viewer that is behind. A browser whose decoder gave up waits for the
    /// next.
    double longest_group_s = 10;
    std::string out;  ///< a file that gets the same bytes; empty: none
};

class LiveEncoder {
public:
    explicit LiveEncoder(const LiveCoding& coding) : coding_(coding) {}

    struct Coded {
        std::string header;  ///< of the stream, with the first frame alone
        std::string bytes;
        bool begins_group = false;   ///< whoever has the header can begin here
        double coarser = 0;          ///< as it was asked for, or as the window's halved pixels make it
        double window_halvings = 0;  ///< how often its pixels have been halved since the first frame
    };
    /// Reads a frame, and its window's where there is one, and removes the files. A group begins as the coding
    /// says, where depth comes nearer, and where the window has another size. One that is asked for begins with this
    /// frame, or with a later one where the last began less than 0.25 s ago; `now_s` is on the server's clock.
    /// `coarser` is in steps of CRF (rate.h). Throws WorkError or InputError.
    Coded encode(const std::string& file, const std::string& window, bool begin_group, double coarser, double now_s);
    /// What ends the stream; nothing where there was no frame.
    std::string finish();

private:
    /// A colour track, with its depth.
    struct Part {
        TrackRole role = TrackRole::main;
        double focal_length_px = default_focal_length_px;  ///< of the views that its depth's error budget is for
        DepthRange range{};                                ///< of the group
        Frame frame{};                                     ///< the one at hand
        double nearest_m = 0;                              ///< in it
        int width = 0, height = 0;                         ///< of its track
    };

    void open();
    void read(Part& part, const std::string& file) const;
    void set_quality(double coarser);
    void write(const Part& part);
    bool needs_group() const;
    bool has_size_of_track(const Part& part) const;
    void follow_size(Part& part);
    double window_halvings() const;
    DepthRange range_before(const Part& part) const;

    LiveCoding coding_;
    DisplayTransform display_;
    std::string taken_;  // bytes that were written; outlives the writer
    std::unique_ptr<StreamWriter> writer_;
    std::vector<Part> parts_;                // main first
    std::unique_ptr<DepthCode> depth_code_;  // null: no depth
    double box_radius_m_ = 0;
    double window_pixels_ = 0;             // of the first frame
    std::optional<double> group_start_s_;  // in scene time
    bool is_group_wanted_ = false;
    double group_began_s_ = 0;                 // on the server's clock
    std::pair<double, double> quality_{0, 0};  // as the encoders have been told: coarser, window_halvings()
};

}  // namespace equistream::serve
