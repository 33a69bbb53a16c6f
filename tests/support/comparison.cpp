#include "tests/support/comparison.hpp"

#include <algorithm>
#include <cmath>

#include "axode/model/building/fault.hpp"

namespace axode::test {

void append(std::vector<double>& out, const Eigen::VectorXd& x) { out.insert(out.end(), x.begin(), x.end()); }
void append(std::vector<double>& out, const Eigen::MatrixXd& x) {
  out.insert(out.end(), x.data(), x.data() + x.size());
}
double largest(const std::vector<double>& x) {
  double m = 0;
  for (const double entry : x) m = std::isnan(entry) ? entry : std::max(m, std::abs(entry));
  return m;
}

Comparison::~Comparison() { testing::Test::RecordProperty(quantity_, to_text(worst_)); }

void Comparison::compare(const std::vector<double>& x, const std::vector<double>& reference, double scale) {
  ASSERT_EQ(x.size(), reference.size());
  std::vector<double> difference;
  for (std::size_t k = 0; k < x.size(); ++k) difference.push_back(x[k] - reference[k]);
  const double error = largest(difference), size = std::max(largest(reference), scale);
  if (error > 0) worst_ = std::max(worst_, error / size);
  EXPECT_TRUE(error <= bound_ * size) << quantity_ << ": differs by " << error << " in " << size;
}

}  // namespace axode::test
