#pragma once
/// A stream that is being made, for all who watch: each viewer gets the header and, from the next group of pictures on,
/// the same bytes as everybody; who steers is told from what they send. One thread: that of the io_context.
#include "feed.h"

#include <equistream/camera.h>

#include <functional>
#include <list>
#include <utility>

namespace equistream::serve {

class LiveFeed;

class LiveStream : public Programme {
public:
    /// `changed`: a viewer has come or gone, or the pose that steers has changed.
    explicit LiveStream(std::function<void()> changed) : changed_(std::move(changed)) {}

    std::unique_ptr<Feed> open_feed() override;

    /// Before any bytes.
    void set_header(const std::string& header);
    void publish(const std::string& bytes, bool begins_group);
    /// There will be no more.
    void end();

    std::size_t viewers() const { return feeds_.size(); }
    /// Of the viewer that came first of those who have sent one.
    std::optional<Pose> steering() const;
    std::int64_t poses_heard() const { return poses_heard_; }
    /// Whether somebody has come since this was asked last, for whom a group should begin.
    bool take_joined() { return std::exchange(joined_, false); }

private:
    friend class LiveFeed;

    std::function<void()> changed_;
    std::list<LiveFeed*> feeds_;  // in the order they came
    std::shared_ptr<const std::string> header_;
    bool joined_ = false, ended_ = false;
    std::int64_t poses_heard_ = 0;
};

}  // namespace equistream::serve
