#include "axode/integration/configuration_group.hpp"

namespace axode {

template class ConfigurationGroup<double>;

}  // namespace axode
