package cairn.spy;

import cairn_lcm.learner_telemetry_t;
import java.awt.event.ActionEvent;
import javax.swing.AbstractAction;
import javax.swing.Action;
import javax.swing.JDesktopPane;
import javax.swing.JFrame;
import lcm.spy.ChannelData;
import lcm.spy.SpyPlugin;

/**
 * Opens the plots of a run on a double click on CAIRN_LEARNER. lcm-spy makes one of it by itself; the decoded view
 * stays in the channel's menu (right click).
 */
public class RunPlugin implements SpyPlugin {
  private JFrame frame; // one for all clicks

  @Override
  public boolean canHandle(long fingerprint) {
    return fingerprint == learner_telemetry_t.LCM_FINGERPRINT;
  }

  @Override
  public Action getAction(JDesktopPane desktop, ChannelData channel) {
    return new AbstractAction("Cairn run") {
      @Override
      public void actionPerformed(ActionEvent event) {
        show();
      }
    };
  }

  private void show() {
    if (frame == null) {
      frame = new JFrame("Cairn run");
      frame.add(new RunPanel());
      frame.setSize(900, 640);
      frame.setLocationByPlatform(true);
    }
    frame.setVisible(true);
    frame.toFront();
  }
}
