// The page: opened from what it carries.

import { carried, complain, opened } from "./app.js";

opened(carried()).then((app) => { window.mafsil = app; }).catch(complain);
