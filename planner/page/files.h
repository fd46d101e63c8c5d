#pragma once

#include <string_view>

namespace cairn::planner {

/// What every page holds besides its data. The build puts the files into the library: a page must stand alone anyway,
/// and so an installed cairn needs neither its sources nor libjs-three.
extern const std::string_view kThreeJs;          ///< three.js, the renderer
extern const std::string_view kOrbitControlsJs;  ///< its camera control
extern const std::string_view kPageJs;           ///< page.js
extern const std::string_view kPageHtml;         ///< page.html, with {{…}} where the others and the data go

}  // namespace cairn::planner
