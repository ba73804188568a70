#include "shadows/light_basis.h"

#include <cmath>

namespace gnomon {

glm::dmat3 lightAxes(const glm::dvec3& towardsSun) {
    const glm::dvec3 z = glm::normalize(towardsSun);
    glm::dvec3 x(1.0, 0.0, 0.0); // in the nadir itself
    if (z.z > -1.0 + 1e-12) {
        const double a = -1.0 / (1.0 + z.z);
        x = glm::dvec3(1.0 + z.x * z.x * a, z.x * z.y * a, -z.x);
    }
    x = glm::normalize(x - glm::dot(x, z) * z); // 1 + z loses its digits towards the nadir
    return glm::dmat3(x, glm::normalize(glm::cross(z, x)), z);
}

Transform<Light, Ecef> lightFromEcef(const Transform<Ecef, Enu>& ecefFromAnchor,
                                     Vector<Ecef> towardsSun) {
    const glm::dmat3 enuFromEcefAxes = glm::transpose(ecefFromAnchor.axes());
    const glm::dmat3 lightFromEnuAxes = glm::transpose(lightAxes(enuFromEcefAxes * towardsSun.xyz));
    const glm::dmat3 rotation = lightFromEnuAxes * enuFromEcefAxes;
    glm::dmat4 m(rotation);
    m[3] = glm::dvec4(-(rotation * ecefFromAnchor.origin().xyz), 1.0);
    return {m};
}

} // namespace gnomon
