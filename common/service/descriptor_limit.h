#pragma once

namespace lumenfarm {

/// Lets this program have as many descriptors as it may: each connection takes some, and most systems give a program
/// few at first.
void raise_descriptor_limit();

}  // namespace lumenfarm
