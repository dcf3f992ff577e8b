#include <math.h>
#include <stdbool.h>

typedef struct vec3 {
    float x, y, z;
} vec3;

static inline vec3 make_vec3(float x, float y, float z) {
    const vec3 v = {x, y, z};
    return v;
}
