/// What a client writes into the memory of its caller: what there is room for, and nothing beside it.
#include "client_folder.h"

#include <equistream/elapsed.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace equistream::test {
namespace {

/// A plane with some samples to spare behind each row and below the last one.
template <typename Sample>
class GuardedPlane {
public:
    GuardedPlane(int width, int height)
        : width_(width), height_(height), samples_(std::size_t(columns()) * std::size_t(height + guard), unwritten) {}

    Sample* data() { return samples_.data(); }
    const Sample* row(int y) const { return samples_.data() + std::size_t(y) * std::size_t(columns()); }
    std::size_t stride() const { return sizeof(Sample) * std::size_t(columns()); }
    bool is_written(int x, int y) const { return row(y)[x] != unwritten; }
    bool is_intact_beside(int width, int height) const {
        for (int y = 0; y < height_ + guard; ++y)
            for (int x = y < height ? width : 0; x < columns(); ++x)
                if (is_written(x, y))
                    return false;
        return true;
    }

private:
    static constexpr int guard = 8;
    static constexpr Sample unwritten = Sample(77);
    int columns() const { return width_ + guard; }

    int width_, height_;
    std::vector<Sample> samples_;
};

struct GuardedEye {
    GuardedEye(int width, int height)
        : pixels(width, height), origin(width, height), confidence(width, height), depth_m(width, height) {}

    es_eye_image image() {
        es_eye_image image{};
        image.pixels = pixels.data();
        image.pixels_stride = pixels.stride();
        image.origin = origin.data();
        image.origin_stride = origin.stride();
        image.depth_m = depth_m.data();
        image.depth_stride = depth_m.stride();
        image.confidence = confidence.data();
        image.confidence_stride = confidence.stride();
        return image;
    }
    bool is_intact_beside(int width, int height) const {
        return pixels.is_intact_beside(width, height) && origin.is_intact_beside(width, height) &&
               confidence.is_intact_beside(width, height) && depth_m.is_intact_beside(width, height);
    }

    GuardedPlane<std::uint32_t> pixels;
    GuardedPlane<std::uint8_t> origin, confidence;
    GuardedPlane<float> depth_m;
};

class ClientPictures : public ClientFolder {
protected:
    std::optional<Client> client;

    void SetUp() override {
        ClientFolder::SetUp();
        es_client_settings judged = settings();
        judged.confidence = 1;
        client.emplace(judged);
    }

    void expect_within_room(const es_client_request& request) {
        SCOPED_TRACE(testing::Message() << request.width << "x" << request.height);
        GuardedEye left(request.width, request.height), right(request.width, request.height);
        es_eye_image images[2] = {left.image(), right.image()};
        client->render(request, images);
        for (const auto& [image, eye] : {std::pair(&images[0], &left), {&images[1], &right}}) {
            EXPECT_GE(image->width, 1);
            EXPECT_LE(image->width, request.width);
            EXPECT_LE(image->height, request.height);
            EXPECT_TRUE(eye->pixels.is_written(image->width - 1, image->height - 1));
            EXPECT_TRUE(eye->is_intact_beside(image->width, image->height));
        }
    }
};

TEST_F(ClientPictures, StayInTheirMemoryAtOddSizes) {
    for (const auto& [width, height] : {std::pair{65, 49}, {65, 48}, {64, 49}, {64, 48}, {1, 1}, {2, 3}})
        expect_within_room(client->request(width, height, pi / 2));
}

TEST_F(ClientPictures, StayInTheirMemoryForEyesThatAreNotSymmetric) {
    for (const int side : {30, 31, 100}) {
        es_client_request request = client->request(side, side, pi / 2);
        for (es_eye_view& eye : request.eyes)
            eye.fov = {-0.9, 0.6, 0.5, -0.7};
        expect_within_room(request);
        request.eyes[1].fov = {-0.3, 1.1, 0.9, -0.2};
        expect_within_room(request);
    }
}

TEST_F(ClientPictures, StayInTheirMemoryForEyesThatAreMostUnequal) {
    es_client_request request = client->request(100, 100, pi / 2);
    const es_field_of_view narrow{-0.0005, 0.0005, 0.0005, -0.0005}, wide{-1.48, 1.48, 1.48, -1.48};
    for (const int which : {0, 1}) {
        request.eyes[which].fov = narrow;
        request.eyes[1 - which].fov = wide;
        expect_within_room(request);
    }
}

/// Odd sizes of an ordinary display have all of their pixels.
TEST_F(ClientPictures, HaveTheSizeOfAnOrdinaryDisplay) {
    ClientPicture eyes[2];
    client->render(client->request(65, 49, pi / 2), eyes);
    for (const ClientPicture& eye : eyes) {
        EXPECT_EQ(eye.width, 65);
        EXPECT_EQ(eye.height, 49);
        EXPECT_NEAR(eye.fov.left, -pi / 4, 1e-9);
    }
}

TEST_F(ClientPictures, AreKeptWithoutASpaceBetweenRows) {
    es_client_request request = client->request(60, 80, pi / 2);
    request.eyes[0].fov = {-0.9, 0.6, 0.5, -0.7};
    request.eyes[1].fov = {-0.2, 0.2, 0.1, -0.1};
    GuardedEye memory[2] = {{60, 80}, {60, 80}};
    es_eye_image images[2] = {memory[0].image(), memory[1].image()};
    client->render(request, images);
    ClientPicture eyes[2];
    client->render(request, eyes);
    EXPECT_LT(eyes[1].width, 60);
    for (int i = 0; i < 2; ++i) {
        const ClientPicture& eye = eyes[i];
        ASSERT_EQ(eye.width, images[i].width);
        ASSERT_EQ(eye.origin.size(), std::size_t(eye.width) * std::size_t(eye.height));
        for (int y = 0; y < eye.height; ++y)
            EXPECT_TRUE(std::equal(memory[i].origin.row(y), memory[i].origin.row(y) + eye.width,
                                   eye.origin.begin() + std::ptrdiff_t(y) * eye.width))
                << y;
    }
}

TEST_F(ClientPictures, AreWhatStatisticsAreOf) {
    es_client_request request = client->request(100, 100, pi / 2);
    request.head.position_m[0] = 0.05;
    for (es_eye_view& eye : request.eyes)
        eye.fov = {-0.05, 0.4, 0.3, -0.2};  // what the ball hid is to the right of the middle
    ClientPicture eyes[2];
    client->render(request, eyes);
    double not_seen = 0, trusted = 0, pixels = 0;
    for (const ClientPicture& eye : eyes) {
        pixels += double(eye.origin.size());
        not_seen += double(eye.origin.size()) - double(std::ranges::count(eye.origin, ES_ORIGIN_SOURCE));
        for (const std::uint8_t sample : eye.confidence)
            trusted += sample / 255.0;
    }
    EXPECT_GT(not_seen, 0);
    EXPECT_NEAR(client->statistics().gaps, not_seen / pixels, 1e-9);
    EXPECT_NEAR(client->statistics().mean_confidence, trusted / pixels, 1e-9);
    const double first_ms = client->statistics().render_ms;
    EXPECT_EQ(client->statistics().pictures_rendered, 1);
    EXPECT_GT(first_ms, 0);
    const auto start = Clock::now();
    client->render(request, eyes);
    EXPECT_EQ(client->statistics().pictures_rendered, 2);
    EXPECT_LE(2 * client->statistics().render_ms, first_ms + milliseconds_since(start)) << "the mean of both";
}

/// Through the C functions, with a struct of another size.
class WrongStructs : public ClientFolder {
protected:
    es_client* client = nullptr;
    es_client_request request{};
    es_client_state state{};
    GuardedEye eye{16, 12};
    es_eye_image images[2] = {eye.image(), eye.image()};

    void SetUp() override {
        ClientFolder::SetUp();
        const es_client_settings still = settings();
        ASSERT_EQ(es_client_open(&still, &client, nullptr), ES_OK);
        request.struct_size = sizeof request;
        request.head.orientation_wxyz[0] = 1;
        request.width = 16;
        request.height = 12;
        ASSERT_EQ(es_client_set_eyes(&request, pi / 2, 0.063, nullptr), ES_OK);
        state.struct_size = sizeof state;
        for (es_eye_image& image : images)
            image.struct_size = sizeof image;
    }
    void TearDown() override {
        es_client_close(client);
        ClientFolder::TearDown();
    }

    void expect_refused(const std::string& words) {
        es_error error{};
        EXPECT_EQ(es_client_render(client, &request, images, &state, &error), ES_BAD_INPUT);
        EXPECT_EQ(std::string(error.text), words);
        EXPECT_TRUE(eye.is_intact_beside(0, 0));
        es_client_statistics statistics{};
        statistics.struct_size = sizeof statistics;
        ASSERT_EQ(es_client_get_statistics(client, &statistics, nullptr), ES_OK);
        EXPECT_EQ(statistics.pictures_rendered, 0);
    }
};

TEST_F(WrongStructs, OfTheStateAreRefusedBeforeAnythingIsDone) {
    state.struct_size = 0;
    expect_refused("es_client_state.struct_size: expected at least " + std::to_string(sizeof state) + ", found 0");
}

/// The second one lies where the first one's size says.
TEST_F(WrongStructs, OfImagesAreRefusedEvenIfTheyAreLarger) {
    const std::string exact = std::to_string(sizeof images[0]), larger = std::to_string(sizeof images[0] + 8);
    images[0].struct_size += 8;
    expect_refused("images[0].struct_size: expected " + exact + ", found " + larger);
    images[0].struct_size -= 8;
    images[1].struct_size = 0;
    expect_refused("images[1].struct_size: expected " + exact + ", found 0");
}

TEST_F(WrongStructs, AreRightOnesOtherwise) {
    EXPECT_EQ(es_client_render(client, &request, images, &state, nullptr), ES_OK);
    EXPECT_EQ(state.frame, 0);
    EXPECT_FALSE(eye.is_intact_beside(0, 0));
}

}  // namespace
}  // namespace equistream::test
