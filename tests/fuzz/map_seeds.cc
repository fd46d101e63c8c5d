#include "tests/fuzz/map_seeds.h"

#include "tests/common/world/import/png_bytes.h"

namespace cairn {

std::vector<std::pair<std::string, std::string>> MapSeeds() {
  std::string octree = "# Octomap OcTree binary file\nid OcTree\nsize 17\nres 0.05\ndata\n";
  for (int level = 0; level < 15; ++level) octree += std::string("\x03\x00", 2);
  octree += std::string("\x09\x46", 2);
  const PngImage grey{4, 3, 8, PNG_COLOR_TYPE_GRAY_ALPHA, std::vector<uint8_t>(24, 255)};
  return {
      {"MapGazebo",
       "<sdf version='1.6'><world name='default'><model name='a'><pose>1 2 0.5 0 0 1.5707963</pose><link name='l'>"
       "<collision name='c'><pose>1 0 0 0 0 "
       "0</pose><geometry><cylinder><radius>0.1</radius><length>1</length></cylinder>"
       "</geometry></collision></link></model><model name='b'><link><collision><geometry><box><size>1 2 3</size></box>"
       "</geometry></collision></link></model><state><model name='b'><pose>4 4 0 0 0 0</pose></model></state></world>"
       "</sdf>"},
      {"MapMovingAi", "type octile\nheight 3\nwidth 4\nmap\n.G@O\nS.TW\n@@@.\n"},
      {"MapScenario", "version 1\n0\ta.map\t4\t3\t0\t1\t2\t2\t2.41421356\n10\ta.map\t4\t3\t0\t0\t3\t0\t5\n"},
      {"MapOctomap", octree},
      {"MapPgm", "P5\n# comment\n4 3 255\n" + std::string("\0\xff\xff\0\0\xff\xcd\0\0\xff\xff\0", 12)},
      {"MapPng", WritePng(grey)},
      {"MapRosYaml",
       "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.5, 2, 0.5]\nnegate: 0\noccupied_thresh: 0.65\n"
       "free_thresh: 0.196\n"},
  };
}

}  // namespace cairn
