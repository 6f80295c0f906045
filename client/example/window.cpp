// A stream in a window, both eyes side by side; the mouse turns the head. Usage: window STREAM [SECONDS]
#include <equistream/client.hpp>

#include <GLFW/glfw3.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

static es_pose turned(es_pose head, double yaw) {  // about the head's own up
    const double c = std::cos(yaw / 2), s = std::sin(yaw / 2), *q = head.orientation_wxyz;
    return {{head.position_m[0], head.position_m[1], head.position_m[2]},
            {q[0] * c - q[2] * s, q[1] * c - q[3] * s, q[0] * s + q[2] * c, q[1] * s + q[3] * c}};
}

int main(int argc, char** argv) try {
    constexpr int width = 640, height = 720;
    if (argc < 2) return std::fprintf(stderr, "usage: window STREAM [SECONDS]\n"), 2;
    if (!glfwInit()) return std::fprintf(stderr, "window: no display\n"), 1;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    GLFWwindow* window = glfwCreateWindow(2 * width, height, argv[1], nullptr, nullptr);
    if (window == nullptr) return std::fprintf(stderr, "window: no OpenGL 4.5\n"), 1;
    glfwMakeContextCurrent(window);
    glfwSwapInterval(1);  // one picture for each refresh of the display
    equistream::Client client(argv[1], ES_BACKEND_OPENGL);
    es_client_request request = client.request(width, height, 1.5);
    const es_pose ahead = request.head;
    while (!glfwWindowShouldClose(window) && (argc < 3 || client.now_s() < std::atof(argv[2]))) {
        double x = 0, y = 0;
        glfwGetCursorPos(window, &x, &y);
        request.head = turned(ahead, -x / width);
        client.send_head(request.head);                              // for a live server, which renders from there
        request.display_s = client.now_s() + 1 / 60.0;               // seen at the next refresh
        es_gl_target targets[2] = {{0, 0, 0, 0}, {0, 0, width, 0}};  // size, framebuffer, x, y
        try {
            client.draw(request, targets);
        } catch (const equistream::ClientError& problem) {
            if (!problem.shown) throw;
            std::fprintf(stderr, "window: %s\n", problem.what());  // the frame before is shown
        }
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
} catch (const std::exception& error) {
    return std::fprintf(stderr, "window: %s\n", error.what()), 1;
}
