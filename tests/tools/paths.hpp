#pragma once
#include <string>

/// Places that a test looks at. One object file knows them (paths.cpp), so that no test is compiled for one folder
/// only.
namespace subsoil::test {

std::string source_dir();  ///< root of the checkout
std::string program();     ///< the built `subsoil`

}  // namespace subsoil::test
