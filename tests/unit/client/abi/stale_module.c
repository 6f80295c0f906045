/* The modules of libequistream_client as another build left them: their tables begin with other code than the
 * library's. */
struct table {
    const char* code;
    void (*functions[2])(void);
};

__attribute__((visibility("default"))) const struct table equistream_client_module_embree = {"0.1.0", {0, 0}};
__attribute__((visibility("default"))) const struct table equistream_client_module_gl = {"0.1.0", {0, 0}};
