#pragma once

#include <string>

namespace viscobar {

/// A scene to start from, sound as it is: every key with its comment out of scene_keys(), those that need not be there
/// commented out, with the default or an example as value.
std::string scene_template();

}  // namespace viscobar
