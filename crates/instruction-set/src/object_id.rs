//! The identities of motion objects: an axis or a coordinate system of a machine, by its index in the configuration.

use std::fmt;

macro_rules! identity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        pub struct $name(pub u16);

        impl $name {
            /// The identities of `count` objects, in the order of the configuration.
            pub fn first(count: usize) -> impl Iterator<Item = Self> + Clone + 'static {
                (0..count).map($name::from_index)
            }

            /// The object at an index of the configuration, which has far fewer than 65,536 of them.
            pub const fn from_index(index: usize) -> Self {
                $name(index as u16)
            }

            /// Index in the configuration, from 0.
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl From<$name> for usize {
            fn from(id: $name) -> usize {
                id.index()
            }
        }

        /// As its index: texts of events are the same for every kind of object.
        impl fmt::Debug for $name {
            fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(out)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(out)
            }
        }
    };
}

identity! {
    /// An axis of the machine.
    AxisId
}

identity! {
    /// A coordinate system of the machine.
    SystemId
}
