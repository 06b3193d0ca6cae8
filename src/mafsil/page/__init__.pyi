from mafsil.page.session import Session as Session
from mafsil.page.show import Page as Page
from mafsil.page.show import show as show
