#include "shadows/splits.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gnomon;

namespace {

std::vector<long double> exactSplits(long double n, long double f, int m, long double lambda) {
    std::vector<long double> out;
    for (int i = 0; i <= m; ++i) {
        const long double s = (long double)i / m;
        out.push_back(lambda * n * std::pow(f / n, s) + (1 - lambda) * (n + (f - n) * s));
    }
    return out;
}

} // namespace

TEST(Splits, RiseStrictlyWithExactEndsAndFollowTheFormula) {
    double worst = 0.0;
    for (const double ratio : {1e-6, 1e-5, 1e-3, 0.01, 0.1, 0.5, 0.9, 0.99, 0.999})
        for (const double far : {1.0, 137.0, 5000.0, 2e7})
            for (int count = 1; count <= 5; ++count)
                for (double lambda = 0.0; lambda <= 1.0; lambda += 0.05) {
                    const double near = ratio * far;
                    const std::vector<double> splits = practicalSplits(near, far, count, lambda);
                    const auto exact = exactSplits(near, far, count, lambda);
                    ASSERT_EQ(splits.size(), std::size_t(count) + 1);
                    ASSERT_EQ(splits.front(), near);
                    ASSERT_EQ(splits.back(), far);
                    for (std::size_t i = 0; i < splits.size(); ++i) {
                        if (i > 0) {
                            ASSERT_GT(splits[i], splits[i - 1])
                                << near << " " << far << " " << lambda;
                        }
                        worst = std::max(worst, double(std::abs(splits[i] - exact[i]) / exact[i]));
                    }
                }
    EXPECT_LE(worst, 1e-6);
    RecordProperty("worstRelativeError", std::to_string(worst));
}

TEST(Splits, AreEvenForLambdaZeroAndGeometricForLambdaOne) {
    const std::vector<double> even = practicalSplits(10.0, 90.0, 4, 0.0);
    const std::vector<double> geometric = practicalSplits(1.0, 10000.0, 4, 1.0);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(even[i], 10.0 + 20.0 * double(i), 1e-12);
        EXPECT_NEAR(geometric[i], std::pow(10.0, double(i)), 1e-9);
    }
}
