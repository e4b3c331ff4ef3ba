"""The look of what Fusion alone leaves heavy: flat bars, quiet docks, segmented buttons.

Lengths are in ``em``, so that they follow the font. ``@name`` is a colour of the theme.
"""

SHEET = """
QMainWindow::separator { background: @line; width: 1px; height: 1px; }
QMenuBar { background: @window; border: none; padding: 0.15em 0.3em; }
QMenuBar::item { padding: 0.25em 0.7em; border-radius: 0.3em; background: transparent; }
QMenuBar::item:selected { background: @hover; }

QToolBar { background: @window; border: none; border-bottom: 1px solid @line;
           padding: 0.3em 0.5em; spacing: 0.15em; }
QToolBar::separator { background: @line; width: 1px; margin: 0.35em 0.55em; }
QToolButton { border: 1px solid transparent; border-radius: 0.35em; padding: 0.32em 0.42em;
              background: transparent; color: @text; }
QToolButton:hover:enabled { background: @hover; }
QToolButton:checked { background: @soft; border-color: @accent; }
QToolButton:pressed { background: @line; }
QToolButton:focus { border-color: @accent; }
QToolButton:disabled { color: @disabled; }
QToolButton[segment="first"], QToolButton[segment="middle"], QToolButton[segment="last"]
    { border: 1px solid @border; background: @base; border-radius: 0;
      padding: 0.3em 0.35em 0.3em 0.5em; }
QToolButton[segment="first"] { border-top-left-radius: 0.4em; border-bottom-left-radius: 0.4em; }
QToolButton[segment="middle"], QToolButton[segment="last"] { border-left: none; }
QToolButton[segment="last"]
    { border-top-right-radius: 0.4em; border-bottom-right-radius: 0.4em; }
QToolButton[segment]:hover:enabled { background: @hover; }
QToolButton[segment]:checked { background: @soft; }
QToolButton[segment]:disabled { background: @window; border-color: @line; }

QPushButton { border: 1px solid @border; border-radius: 0.4em; padding: 0.38em 1em;
              background: @raised; color: @text; }
QPushButton:hover:enabled { background: @hover; }
QPushButton:pressed { background: @line; }
QPushButton:checked { background: @soft; border-color: @accent; }
QPushButton:focus { border-color: @accent; }
QPushButton:disabled { color: @disabled; border-color: @line; background: @window; }
QPushButton[primary="true"], QPushButton:default
    { background: @accent; border-color: @accent; color: @on_accent; }
QPushButton[primary="true"]:hover, QPushButton:default:hover { border-color: @text; }
QPushButton[primary="true"]:disabled, QPushButton:default:disabled
    { background: @window; border-color: @line; color: @disabled; }

QDialogButtonBox, QMessageBox { dialogbuttonbox-buttons-have-icons: 0; }

QRadioButton::indicator, QCheckBox::indicator, QAbstractItemView::indicator
    { width: 0.95em; height: 0.95em; border: 1px solid @border; background: @base; }
QRadioButton::indicator { border-radius: 0.52em; }
QCheckBox::indicator, QAbstractItemView::indicator { border-radius: 0.2em; }
QAbstractItemView::indicator { width: 0.78em; height: 0.78em; }
QRadioButton::indicator:checked
    { background: qradialgradient(cx: 0.5, cy: 0.5, radius: 0.5, fx: 0.5, fy: 0.5,
      stop: 0 @accent, stop: 0.5 @accent, stop: 0.6 @base, stop: 1 @base);
      border-color: @accent; }
QCheckBox::indicator:checked, QAbstractItemView::indicator:checked
    { background: @accent; border-color: @accent; image: url("@check;"); }
QCheckBox::indicator:indeterminate, QAbstractItemView::indicator:indeterminate
    { background: @soft; border-color: @accent; }
QRadioButton::indicator:disabled, QCheckBox::indicator:disabled
    { border-color: @line; background: @window; }

QDockWidget { titlebar-close-icon: none; titlebar-normal-icon: none; font-weight: 600; }
QDockWidget::title { background: @window; padding: 0.45em 0.7em; border-bottom: 1px solid @line; }
QTabBar { qproperty-drawBase: 0; }
QTabBar::tab { background: transparent; color: @faint; border: none; padding: 0.4em 0.8em;
               border-bottom: 0.16em solid transparent; }
QTabBar::tab:selected { color: @text; border-bottom-color: @accent; }
QTabBar::tab:right { padding: 0.8em 0.4em; border-bottom: none;
                     border-left: 0.16em solid transparent; }
QTabBar::tab:right:selected { border-left-color: @accent; }
QTabBar::tab:hover:!selected { color: @text; background: @hover; }
QHeaderView::section { background: @window; color: @faint; border: none;
                       border-bottom: 1px solid @line; padding: 0.3em 0.5em; }
QAbstractItemView { border: 1px solid @line; selection-background-color: @soft;
                    selection-color: @text; }
QMenu::separator { background: @line; height: 1px; margin: 0.3em 0.6em; }

QProgressBar { border: 1px solid @line; border-radius: 0.35em; background: @base;
               text-align: center; min-height: 0.9em; max-height: 1.1em; }
QProgressBar::chunk { background: @accent; border-radius: 0.3em; }
QStatusBar { background: @window; border-top: 1px solid @line; }
QStatusBar::item { border: none; }
QToolTip { background: @raised; color: @text; border: 1px solid @border; padding: 0.3em; }
QLabel[faint="true"] { color: @faint; }
QLabel[fault="true"] { color: @fault; }
QLabel[heading="true"] { font-size: 20pt; font-weight: 300; }

QFrame[notice="info"] { background: @notice; border: none; border-bottom: 1px solid @line; }
QFrame[notice="warning"] { background: @warning; border: none; border-bottom: 1px solid @line; }
QFrame[notice="error"] { background: @error; border: none; border-bottom: 1px solid @line; }
"""
